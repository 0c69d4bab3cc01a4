#include "store/run_log.h"

#include <algorithm>

#include "store/error.h"

namespace phiz {
namespace {

constexpr std::size_t kCheckDigits = 16;
constexpr std::uint64_t kMaxLogBytes = std::uint64_t{1} << 30;

std::string check_of(std::string_view text) {
  return compute_digest(text).hex().substr(0, kCheckDigits);
}

void take_lines(std::string_view text, std::vector<std::string>& lines) {
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return;  // cut in the middle
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end + 1);
    if (line.size() <= kCheckDigits || line[kCheckDigits] != ' ') continue;
    const std::string_view said = line.substr(kCheckDigits + 1);
    if (check_of(said) == line.substr(0, kCheckDigits)) lines.emplace_back(said);
  }
}

}  // namespace

RunLog::RunLog(const Store& store, const ProcessIdentity& self)
    : store_(store),
      file_(store.layout().logs() / (compute_digest(self.place).hex().substr(0, 8) + "-" +
                                     std::to_string(self.start) + "-" + std::to_string(self.pid) + ".log")) {}

void RunLog::append(const std::string& text) noexcept {
  try {
    std::string line = text;
    std::replace_if(
        line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
    line = check_of(line) + " " + line + "\n";
    const std::lock_guard lock(mutex_);
    store_.files().append(file_, std::as_bytes(std::span(line)));
  } catch (const std::exception&) {
    // Nothing depends on it.
  }
}

std::vector<std::string> read_run_log(const Store& store) {
  std::vector<std::string> lines;
  for (const std::string& name : store.files().list_folder(store.layout().logs())) {
    if (!name.ends_with(".log")) continue;
    take_lines(store.files().read_file(store.layout().logs() / name, kMaxLogBytes), lines);
  }
  std::sort(lines.begin(), lines.end());
  return lines;
}

}  // namespace phiz
