#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace phiz::test {

/// How a program ended and what it said.
struct ProgramRun {
  int exit_code = -1;  ///< 128 + signal where a signal ended it
  std::string out, err;
  double seconds = 0;            ///< wall clock
  double processor_seconds = 0;  ///< of all its threads
  std::uint64_t peak_memory_bytes =
      0;  ///< resident; never less than this process had when it started the run
};

struct ProgramOptions {
  std::filesystem::path folder;        ///< to run in; empty: this process's
  std::optional<double> kill_after_s;  ///< SIGKILL at that instant, unless it has ended
  std::string out_file;                ///< stdout goes there instead of ProgramRun::out
};

/// Runs a program to its end. argv[0] is its path. Throws std::system_error where it cannot be started.
ProgramRun run_program(const std::vector<std::string>& argv, const ProgramOptions& options = {});

/// The built program: $PHIZ_PROGRAM, else the one of this build.
std::filesystem::path phiz_program();

}  // namespace phiz::test
