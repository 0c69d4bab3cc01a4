#pragma once

#include <exception>
#include <span>
#include <string>

namespace phiz {

struct ExitCode {
  int code;
  const char* meaning;
};

/// Every code phiz ends with, in order: the one table behind `phiz --help`, the README and describe_failure.
std::span<const ExitCode> exit_codes();

enum : int {
  kExitDone = 0,
  kExitFailed = 1,
  kExitUsage = 2,
  kExitSomeFailed = 3,
  kExitBadInput = 4,
  kExitNoStore = 10,
  kExitLeaseHeld = 11,
  kExitDamaged = 12,
  kExitDisk = 13,
  kExitRejected = 14,
  kExitBug = 70,
  kExitInterrupted = 130,
  kExitTerminated = 143,
};

/// What a user is told of an exception.
struct Failure {
  int code = kExitFailed;
  std::string what;  ///< one line
  std::string hint;  ///< one line or empty
};

/// The one place that maps exception types to exit codes.
Failure describe_failure(std::exception_ptr exception);

/// `text` on one line: control characters become spaces.
std::string to_one_line(std::string text);

}  // namespace phiz
