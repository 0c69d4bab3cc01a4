#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace phiz {

/// A command line or configuration that cannot be carried out; nothing has run (exit code 2).
class UsageError : public std::runtime_error {
 public:
  explicit UsageError(const std::string& what, std::string hint = {})
      : std::runtime_error(what), hint_(std::move(hint)) {}
  const std::string& hint() const { return hint_; }

 private:
  std::string hint_;
};

/// The user asked to stop and the work reached a safe point (exit code 128 + signal).
class Interrupted : public std::runtime_error {
 public:
  explicit Interrupted(int signal) : std::runtime_error("interrupted"), signal_(signal) {}
  int signal() const { return signal_; }

 private:
  int signal_;
};

/// This program has only the tables of the stages, not the stages: the engine has to take over.
class EngineNeeded : public std::runtime_error {
 public:
  EngineNeeded() : std::runtime_error("the stages are not linked into this program") {}
};

}  // namespace phiz
