#pragma once

#include <mutex>
#include <string>
#include <string_view>
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
  const std::string name_;
  int parts_ = 0;  ///< files that ended in a failure
  std::mutex mutex_;
};

/// What is wrong with a log that was not merely cut short: the number of the first line that is not as it was
/// written; 0 if there is none.
std::size_t find_damaged_line(std::string_view log);

/// A file in `logs/` that is named after its own bytes, for what must not change between writing and use: the
/// start of their SHA-256 before the extension. `name` and `extension` as in "slurm-1" and ".csv".
std::string make_checked_name(const std::string& name, std::string_view bytes, const std::string& extension);
/// True for a file of another kind too.
bool is_as_its_name_says(const std::string& file_name, std::string_view bytes);

/// Every whole line of every process, sorted; lines begin with their time, so this is by time.
std::vector<std::string> read_run_log(const Store& store);

}  // namespace phiz
