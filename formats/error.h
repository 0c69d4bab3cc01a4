#pragma once

#include <stdexcept>
#include <string>

namespace phiz {

/// A file that cannot be read, or cannot be written as asked.
/// `what()` is one line: the fault, then the place (line or byte) in parentheses.
/// `hint` says how to mend it and may be empty. The file's path is added by whoever opened it.
class FormatError : public std::runtime_error {
 public:
  explicit FormatError(const std::string& what, std::string hint = {})
      : std::runtime_error(what), hint_(std::move(hint)) {}
  const std::string& hint() const { return hint_; }

 private:
  std::string hint_;
};

}  // namespace phiz
