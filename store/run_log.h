#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "store/process.h"
#include "store/store.h"

namespace phiz {

/// What processes did in a store, for people: one file a process in `logs/`, one line an event, made with the
/// first event. Never needed for anything else. A line is 16 hex digits (the start of the SHA-256 of the
/// rest), a space and the text, so that a tail cut by a kill or a power cut is told from a line.
class RunLog {
 public:
  RunLog(const Store& store, const ProcessIdentity& self);

  /// One line; control characters become spaces. A log that cannot be written is silent: work goes on.
  void append(const std::string& text) noexcept;

 private:
  const Store& store_;
  std::filesystem::path file_;
  std::mutex mutex_;
};

/// Every whole line of every process, sorted; lines begin with their time, so this is by time.
std::vector<std::string> read_run_log(const Store& store);

}  // namespace phiz
