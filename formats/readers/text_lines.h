#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace phiz::readers {

/// The lines of a text: ended by LF, CR LF, or CR alone where the text has no LF. A UTF-8 mark at the front
/// is skipped.
class TextLines {
 public:
  /// Throws FormatError if the text is UTF-16. `first_line` is the number of the first line.
  explicit TextLines(std::span<const std::byte> bytes, std::uint64_t first_line = 1);

  /// The next line without its end; false when there is none.
  bool next(std::string_view& line);
  /// The next line that is not blank.
  bool next_filled(std::string_view& line);
  /// Number of the line given last, counted from 1.
  std::uint64_t number() const { return number_; }
  std::size_t bytes_left() const { return static_cast<std::size_t>(end_ - at_); }

 private:
  const char* at_;
  const char* end_;
  char terminator_ = '\n';
  std::uint64_t number_;
};

inline bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

/// Parses the number at the front of [first, last). Returns where it ends, or null if there is none. A
/// leading "+", "nan", "inf" and the old Windows forms ("-1.#IND") are numbers; too large is infinite.
/// Independent of the locale.
const char* parse_number(const char* first, const char* last, double& value);

/// The blank-separated fields of one line.
class Fields {
 public:
  Fields(std::string_view line, std::uint64_t line_number)
      : at_(line.data()), end_(line.data() + line.size()), line_number_(line_number) {}

  bool at_end() {
    while (at_ < end_ && is_blank(*at_)) ++at_;
    return at_ == end_;
  }
  /// False at the end of the line. Throws FormatError, naming the line, if the field is not a number.
  bool next_number(double& value) {
    if (at_end()) return false;
    const char* stop = parse_number(at_, end_, value);
    if (!stop || (stop < end_ && !is_blank(*stop))) fail_not_a_number();
    at_ = stop;
    return true;
  }
  /// A number that must be there.
  double number(std::string_view meaning);
  /// Empty at the end of the line.
  std::string_view next_word();
  std::uint64_t line_number() const { return line_number_; }

 private:
  [[noreturn]] void fail_not_a_number();

  const char* at_;
  const char* end_;
  std::uint64_t line_number_;
};

/// Compares without regard to the case of ASCII letters; `lower` is given in lower case.
bool equals_lower(std::string_view text, std::string_view lower);

}  // namespace phiz::readers
