#include "formats/readers/text_lines.h"

#include <charconv>
#include <cstring>
#include <limits>
#include <string>

#include "formats/readers/fail.h"

namespace phiz::readers {
namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

char to_lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

/// from_chars says "out of range" for what is too large and for what is too small.
double out_of_range_value(const char* first, const char* last) {
  const bool is_negative = *first == '-';
  const char* digits = first + (is_negative ? 1 : 0);
  double magnitude = std::numeric_limits<double>::infinity();
  const char* exponent = digits;
  while (exponent < last && to_lower(*exponent) != 'e') ++exponent;
  if (exponent + 1 < last ? exponent[1] == '-' : *digits == '0' || *digits == '.') magnitude = 0.0;
  return is_negative ? -magnitude : magnitude;
}

/// "1.#INF", "1.#QNAN", "-1.#IND00": what old Windows libraries print. `mark` is at the '#'.
const char* windows_form(const char* mark, const char* last, bool is_negative, double& value) {
  const char* stop = mark + 1;
  while (stop < last && (is_digit(*stop) || (to_lower(*stop) >= 'a' && to_lower(*stop) <= 'z'))) ++stop;
  const bool is_infinite = stop - mark >= 4 && equals_lower({mark + 1, 3}, "inf");
  value = is_infinite ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
  if (is_negative) value = -value;
  return stop;
}

const char* parse_general(const char* first, const char* last, double& value) {
  if (first < last && *first == '+') {
    ++first;
    if (first < last && *first == '-') return nullptr;
  }
  const auto [stop, error] = std::from_chars(first, last, value);
  if (error == std::errc::invalid_argument) return nullptr;
  if (error == std::errc::result_out_of_range) value = out_of_range_value(first, stop);
  if (stop < last && *stop == '#') return windows_form(stop, last, *first == '-', value);
  return stop;
}

constexpr double kPowersOfTen[] = {1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                   1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};

}  // namespace

TextLines::TextLines(std::span<const std::byte> bytes, std::uint64_t first_line)
    : at_(reinterpret_cast<const char*>(bytes.data())), end_(at_ + bytes.size()), number_(first_line - 1) {
  const std::string_view text(at_, bytes.size());
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    fail_at_byte("is UTF-16 text", 0, "save it as UTF-8 or plain ASCII");
  if (text.starts_with("\xEF\xBB\xBF")) at_ += 3;
  if (!bytes.empty() && !std::memchr(at_, '\n', bytes_left()) && std::memchr(at_, '\r', bytes_left()))
    terminator_ = '\r';
}

bool TextLines::next(std::string_view& line) {
  if (at_ == end_) return false;
  const auto* stop = static_cast<const char*>(std::memchr(at_, terminator_, bytes_left()));
  const char* line_end = stop ? stop : end_;
  line = {at_, static_cast<std::size_t>(line_end - at_)};
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  at_ = stop ? stop + 1 : end_;
  ++number_;
  return true;
}

bool TextLines::next_filled(std::string_view& line) {
  while (next(line))
    for (const char c : line)
      if (!is_blank(c)) return true;
  return false;
}

// Most numbers of a scan are short decimals: at most 15 digits make an exact integer, and one division by an
// exact power of ten rounds correctly (Clinger 1990, "How to read floating point numbers accurately"). The
// rest goes to std::from_chars, with the same result where both apply.
const char* parse_number(const char* first, const char* last, double& value) {
  const char* at = first;
  const bool is_negative = at < last && *at == '-';
  if (is_negative) ++at;
  const char* digits = at;
  std::uint64_t mantissa = 0;
  while (at < last && is_digit(*at)) mantissa = mantissa * 10 + static_cast<std::uint64_t>(*at++ - '0');
  std::ptrdiff_t count = at - digits, decimals = 0;
  if (at < last && *at == '.') {
    const char* point = at++;
    while (at < last && is_digit(*at)) mantissa = mantissa * 10 + static_cast<std::uint64_t>(*at++ - '0');
    decimals = at - point - 1;
    count += decimals;
  }
  const bool goes_on = at < last && (*at == 'e' || *at == 'E' || *at == '#');
  if (count == 0 || count > 15 || goes_on) return parse_general(first, last, value);
  const double magnitude = static_cast<double>(mantissa) / kPowersOfTen[decimals];
  value = is_negative ? -magnitude : magnitude;
  return at;
}

double Fields::number(std::string_view meaning) {
  double value = 0.0;
  if (!next_number(value)) fail_at_line(std::string(meaning) + " is missing", line_number_, kHintCut);
  return value;
}

std::string_view Fields::next_word() {
  if (at_end()) return {};
  const char* first = at_;
  while (at_ < end_ && !is_blank(*at_)) ++at_;
  return {first, static_cast<std::size_t>(at_ - first)};
}

void Fields::fail_not_a_number() {
  const std::string_view word = next_word();
  const bool has_comma = word.find(',') != std::string_view::npos;
  fail_at_line(quoted(word) + " is not a number", line_number_,
               has_comma ? "decimal commas are not understood: export with decimal points" : kHintDamaged);
}

bool equals_lower(std::string_view text, std::string_view lower) {
  if (text.size() != lower.size()) return false;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (to_lower(text[i]) != lower[i]) return false;
  return true;
}

}  // namespace phiz::readers
