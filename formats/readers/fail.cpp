#include "formats/readers/fail.h"

namespace phiz::readers {

void fail_at_line(const std::string& fault, std::uint64_t line, const std::string& hint) {
  throw FormatError(fault + " (line " + std::to_string(line) + ")", hint);
}

void fail_at_byte(const std::string& fault, std::uint64_t byte, const std::string& hint) {
  throw FormatError(fault + " (byte " + std::to_string(byte) + ")", hint);
}

std::string quoted(std::string_view text) {
  constexpr std::size_t kLongest = 24;
  std::string result = "'";
  for (const char c : text.substr(0, kLongest)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + (text.size() > kLongest ? "...'" : "'");
}

}  // namespace phiz::readers
