#pragma once

#include <stdexcept>
#include <string>

namespace phiz {

/// Input that a stage cannot work on (exit code 4). One line, and how to mend it.
class InvalidInput : public std::runtime_error {
 public:
  explicit InvalidInput(const std::string& what, std::string hint = {})
      : std::runtime_error(what), hint_(std::move(hint)) {}
  const std::string& hint() const { return hint_; }

 private:
  std::string hint_;
};

/// A fit that its own checks found wrong: not a head, collapsed, too far (exit code 14).
class FitRejected : public std::runtime_error {
 public:
  explicit FitRejected(const std::string& what, std::string hint = {})
      : std::runtime_error(what), hint_(std::move(hint)) {}
  const std::string& hint() const { return hint_; }

 private:
  std::string hint_;
};

/// A computation that did not reach a usable result (exit code 1).
class NumericalFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A broken promise inside phiz: a bug, never the user's data (exit code 70).
class ContractViolation : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

}  // namespace phiz

#define PHIZ_STRINGIFY_INNER(x) #x
#define PHIZ_STRINGIFY(x) PHIZ_STRINGIFY_INNER(x)
/// Precondition of a function on its caller. Always checked; the cost must be negligible.
#define CONTRACT(cond)                                                                    \
  do {                                                                                    \
    if (!(cond)) throw ::phiz::ContractViolation(__FILE__ ":" PHIZ_STRINGIFY(__LINE__) ": " #cond); \
  } while (false)
