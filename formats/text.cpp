#include "formats/text.h"

#include <array>
#include <charconv>
#include <istream>
#include <ostream>

#include "formats/error.h"

namespace phiz {
namespace {

template <typename Number>
bool parse_whole(std::string_view token, Number& value) {
  const auto [end, fault] = std::from_chars(token.data(), token.data() + token.size(), value);
  return fault == std::errc{} && end == token.data() + token.size();
}

}  // namespace

void append_fixed(std::string& text, double value, int decimals, bool trim) {
  std::array<char, 352> buffer;  // the largest double has 309 digits before the point
  const auto result =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, decimals);
  std::string_view digits(buffer.data(), static_cast<std::size_t>(result.ptr - buffer.data()));
  if (trim && digits.find('.') != std::string_view::npos) {
    digits = digits.substr(0, digits.find_last_not_of('0') + 1);
    if (digits.back() == '.') digits.remove_suffix(1);
  }
  if (digits.front() == '-' && digits.find_first_not_of("-0.") == std::string_view::npos) {
    digits.remove_prefix(1);
  }
  text += digits;
}

bool parse_number(std::string_view token, double& value) {
  return parse_whole(token, value);
}
bool parse_number(std::string_view token, int& value) {
  return parse_whole(token, value);
}

std::string read_all(std::istream& in) {
  std::string bytes;
  std::array<char, 1 << 16> block;
  while (in.read(block.data(), block.size()) || in.gcount() > 0) {
    bytes.append(block.data(), static_cast<std::size_t>(in.gcount()));
  }
  if (in.bad() || !in.eof()) throw FormatError("cannot be read (byte " + std::to_string(bytes.size()) + ")");
  return bytes;
}

void write_all(std::ostream& out, std::string_view bytes) {
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out) throw FormatError("could not be written in full");
}

}  // namespace phiz
