#include "store/run_log.h"

#include <algorithm>
#include <optional>

#include "store/error.h"

namespace phiz {
namespace {

constexpr std::size_t kCheckDigits = 16;
constexpr std::uint64_t kMaxLogBytes = std::uint64_t{1} << 30;

std::string check_of(std::string_view text) {
  return compute_digest(text).hex().substr(0, kCheckDigits);
}

/// What a whole line says; nothing if it is not as it was written.
std::optional<std::string_view> read_line(std::string_view line) {
  if (line.size() <= kCheckDigits || line[kCheckDigits] != ' ') return std::nullopt;
  const std::string_view said = line.substr(kCheckDigits + 1);
  if (check_of(said) != line.substr(0, kCheckDigits)) return std::nullopt;
  return said;
}

void take_lines(std::string_view text, std::vector<std::string>& lines) {
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return;  // cut in the middle
    if (const auto said = read_line(text.substr(0, end))) lines.emplace_back(*said);
    text.remove_prefix(end + 1);
  }
}

}  // namespace

RunLog::RunLog(const Store& store, const ProcessIdentity& self)
    : store_(store),
      name_(compute_digest(self.place).hex().substr(0, 8) + "-" + std::to_string(self.start) + "-" +
            std::to_string(self.pid)) {}

void RunLog::append(const std::string& text) noexcept {
  const std::lock_guard lock(mutex_);
  try {
    std::string line = text;
    std::replace_if(
        line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
    line = check_of(line) + " " + line + "\n";
    const std::string part = parts_ > 0 ? "." + std::to_string(parts_) : "";
    store_.files().append(store_.layout().logs() / (name_ + part + ".log"), std::as_bytes(std::span(line)));
  } catch (const std::exception&) {
    ++parts_;  // half a line may stand there: nothing is written behind it
  }
}

std::size_t find_damaged_line(std::string_view log) {
  for (std::size_t number = 1; !log.empty(); ++number) {
    const std::size_t end = log.find('\n');
    // A cut tail is no damage, unless it is a whole line whose end has become another character.
    if (end == std::string_view::npos) return read_line(log.substr(0, log.size() - 1)) ? number : 0;
    if (!read_line(log.substr(0, end))) return number;
    log.remove_prefix(end + 1);
  }
  return 0;
}

std::string make_checked_name(const std::string& name, std::string_view bytes, const std::string& extension) {
  return name + "-" + check_of(bytes) + extension;
}

bool is_as_its_name_says(const std::string& file_name, std::string_view bytes) {
  const std::size_t dot = file_name.rfind('.'), dash = file_name.rfind('-');
  const bool has_digits =
      dot != std::string::npos && dash != std::string::npos && dot > dash && dot - dash - 1 == kCheckDigits;
  if (!has_digits || file_name.ends_with(".log")) return true;
  return file_name.substr(dash + 1, kCheckDigits) == check_of(bytes);
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
