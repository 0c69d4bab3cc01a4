// Points as columns of numbers: XYZ, PTS, CSV. Cells are separated by ';' or ',' if the first row has one,
// else by blanks. Lines that begin with # or // are comments. A line of names (also as the last comment
// before the rows) tells the columns: x y z, nx ny nz, r g b or red green blue, confidence. Without names, by
// their number:
//   3-5  x y z, the rest unused        6  x y z and normal or colour      7  x y z, intensity, colour (or
//   normal first) 9    x y z, normal and colour in either order                         8, 10+  x y z, and
//   normal if it is one
// Three columns are a normal if in nine of ten of the first rows their length is within 2 % of 1.
// A PTS file counts its points in a line of its own before each block of them.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "formats/readers/cloud_builder.h"
#include "formats/readers/fail.h"
#include "formats/readers/readers.h"
#include "formats/readers/text_lines.h"

namespace phiz::readers {
namespace {

constexpr int kMaxColumns = 64;
constexpr int kSurveyRows = 64;
constexpr std::size_t kLeastRowBytes = 6;  // "0 0 0" and a line end

bool is_comment(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t");
  return first != std::string_view::npos && (line[first] == '#' || line.substr(first).starts_with("//"));
}

/// ';' or ',' or, for blanks, ' '.
char separator_of(std::string_view line) {
  if (line.find(';') != std::string_view::npos) return ';';
  const std::size_t comma = line.find(',');
  if (comma == std::string_view::npos) return ' ';
  // "1,5 2,5 3,5" is three numbers: blanks stand between digits and no comma stands beside a blank.
  bool comma_by_blank = false, blank_between = false;
  for (std::size_t i = 1; i + 1 < line.size(); ++i) {
    if (line[i] == ',') comma_by_blank |= is_blank(line[i - 1]) || is_blank(line[i + 1]);
    if (is_blank(line[i]))
      blank_between |= line[i - 1] != ',' && line[i + 1] != ',' && !is_blank(line[i + 1]);
  }
  return blank_between && !comma_by_blank ? ' ' : ',';
}

/// The cells of one row.
class Cells {
 public:
  Cells(std::string_view line, char separator)
      : at_(line.data()), end_(at_ + line.size()), separator_(separator) {}

  /// As next(), for a cell that is a number; an empty one is not-a-number, text is given as `bad_cell`.
  bool next_number(double& value, std::string_view& bad_cell) {
    skip_blanks();
    if (at_ == end_) return false;
    const char* const first = at_;
    if (const char* stop = parse_number(at_, end_, value)) {
      at_ = stop;
      skip_blanks();
      const bool is_whole_cell = at_ == end_ || is_separator(*at_) || (separator_ == ' ' && at_ > stop);
      if (is_whole_cell) {
        if (at_ < end_ && separator_ != ' ') ++at_;
        return true;
      }
      at_ = first;
    }
    std::string_view cell;
    next(cell);
    value = std::numeric_limits<double>::quiet_NaN();
    if (!cell.empty()) bad_cell = cell;
    return true;
  }

  /// False at the end of the row. An empty cell between separators is empty; behind the last separator is
  /// none.
  bool next(std::string_view& cell) {
    skip_blanks();
    if (at_ == end_) return false;
    const char* first = at_;
    while (at_ < end_ && !is_separator(*at_)) ++at_;
    const char* last = at_;
    while (last > first && is_blank(last[-1])) --last;
    if (at_ < end_) ++at_;
    cell = {first, static_cast<std::size_t>(last - first)};
    return true;
  }

 private:
  bool is_separator(char c) const { return separator_ == ' ' ? is_blank(c) : c == separator_; }
  void skip_blanks() {
    while (at_ < end_ && is_blank(*at_)) ++at_;
  }

  const char* at_;
  const char* end_;
  char separator_;
};

/// Numbers of a row; -1 if a cell is not one (it is then in `bad_cell`).
int parse_row(std::string_view line, char separator, double (&values)[kMaxColumns],
              std::string_view& bad_cell) {
  Cells cells(line, separator);
  int count = 0;
  while (count < kMaxColumns && cells.next_number(values[count], bad_cell)) {
    if (!bad_cell.empty()) return -1;
    ++count;
  }
  return count;
}

bool is_whole(double value) {
  return value >= 0.0 && value < 1e15 && value == std::floor(value);
}

struct Columns {
  int count = 0;
  std::array<int, 3> position{0, 1, 2};
  std::array<int, 3> normal{}, colour{};
  int confidence = -1;
  bool has_normal = false, has_colour = false;

  void set_normal(int first) {
    normal = {first, first + 1, first + 2};
    has_normal = true;
  }
  void set_colour(int first) {
    colour = {first, first + 1, first + 2};
    has_colour = true;
  }
};

/// "x [mm]" and "\"X\"" are "x".
std::vector<std::string> parse_names(std::string_view line) {
  line.remove_prefix(std::min(line.find_first_not_of("#/ \t"), line.size()));
  std::vector<std::string> names;
  Cells cells(line, separator_of(line));
  for (std::string_view cell; cells.next(cell);) {
    std::string name;
    for (const char c : cell) {
      const char lower = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
      const bool is_letter = lower >= 'a' && lower <= 'z';
      if (is_letter) name += lower;
      if (!is_letter && !name.empty()) break;
    }
    names.push_back(name);
  }
  return names;
}

bool find_three(const std::vector<std::string>& names, const std::array<const char*, 3>& wanted,
                std::array<int, 3>& columns) {
  for (int i = 0; i < 3; ++i) {
    const auto found = std::find(names.begin(), names.end(), wanted[i]);
    if (found == names.end()) return false;
    columns[i] = static_cast<int>(found - names.begin());
  }
  return true;
}

/// False if the names do not tell where x, y and z are.
bool assign_by_names(const std::vector<std::string>& names, Columns& columns) {
  if (!find_three(names, {"x", "y", "z"}, columns.position)) return false;
  columns.has_normal = find_three(names, {"nx", "ny", "nz"}, columns.normal);
  columns.has_colour = find_three(names, {"r", "g", "b"}, columns.colour) ||
                       find_three(names, {"red", "green", "blue"}, columns.colour);
  const auto confidence = std::find(names.begin(), names.end(), "confidence");
  if (confidence != names.end()) columns.confidence = static_cast<int>(confidence - names.begin());
  return true;
}

using Sample = std::vector<std::array<double, kMaxColumns>>;

bool looks_like_normal(const Sample& sample, int first) {
  std::size_t unit = 0, zero = 0;
  for (const auto& row : sample) {
    const double length = std::hypot(row[first], row[first + 1], row[first + 2]);
    unit += std::abs(length - 1.0) < 0.02;
    zero += length == 0.0;
  }
  return unit > 0 && 10 * (unit + zero) >= 9 * sample.size();
}

bool looks_like_colour(const Sample& sample, int first) {
  for (const auto& row : sample)
    for (int i = first; i < first + 3; ++i)
      if (row[i] < 0.0 || row[i] > 65535.0) return false;
  return true;
}

void assign_by_count(const Sample& sample, Columns& columns) {
  const int count = columns.count;
  const auto normal_at = [&](int first) { return first + 3 <= count && looks_like_normal(sample, first); };
  int colour = -1;
  if (normal_at(3)) {
    columns.set_normal(3);
    if (count == 9) colour = 6;
  } else if (count == 9 && normal_at(6)) {
    columns.set_normal(6);
    colour = 3;
  } else if (count == 7 && normal_at(4)) {
    columns.set_normal(4);
  } else if (count == 6 || count == 9) {
    colour = 3;
  } else if (count == 7) {
    colour = 4;
  }
  if (colour >= 0 && looks_like_colour(sample, colour)) columns.set_colour(colour);
}

class TextReader {
 public:
  TextReader(std::span<const std::byte> bytes, const ScanLimits& limits) : lines_(bytes), limits_(limits) {}

  ScanFile read() {
    survey();
    reserve();
    std::string_view line;
    while (next_row(line)) take_row(line);
    if (rows_in_block_ < block_size_) fail_count();
    return builder_.finish("text", ColourRange::numbers);
  }

 private:
  /// Reads the first rows to learn what the columns are; leaves the lines before the first row.
  void survey() {
    std::string_view line;
    std::vector<std::string> names;
    if (!skip_to_rows(line, names))
      throw FormatError("holds no points (line " + std::to_string(lines_.number()) + ")");
    TextLines ahead = first_row_;
    Sample sample;
    while (sample.size() < kSurveyRows && ahead.next_filled(line)) {
      if (is_comment(line)) continue;
      std::string_view bad_cell;
      double values[kMaxColumns] = {};
      const int count = parse_row(line, separator_, values, bad_cell);
      if (count == 1 && is_whole(values[0]) && columns_.count == 0) continue;  // the count of a PTS block
      if (columns_.count == 0) columns_.count = count;
      if (count != columns_.count || count < 3) break;  // take_row() will say what is wrong
      sample.push_back(std::to_array(values));
    }
    if (!(names.size() == static_cast<std::size_t>(columns_.count) && assign_by_names(names, columns_)))
      assign_by_count(sample, columns_);
    lines_ = first_row_;
  }

  /// Passes comments and at most one line of names. Sets `first_row_` to where the rows begin.
  bool skip_to_rows(std::string_view& line, std::vector<std::string>& names) {
    bool has_header = false;
    for (first_row_ = lines_; lines_.next_filled(line); first_row_ = lines_) {
      if (is_comment(line)) {
        names = parse_names(line);
        continue;
      }
      separator_ = separator_of(line);
      if (has_header || !is_all_words(line)) return true;
      has_header = true;
      names = parse_names(line);
    }
    return false;
  }

  bool is_all_words(std::string_view line) const {
    Cells cells(line, separator_);
    double ignored = 0.0;
    for (std::string_view cell; cells.next(cell);)
      if (cell.empty() || parse_number(cell.data(), cell.data() + cell.size(), ignored)) return false;
    return true;
  }

  void reserve() {
    const std::size_t rows = count_of_line_ends() + 1;
    builder_.reserve(std::min(
        {rows, lines_.bytes_left() / kLeastRowBytes + 1, static_cast<std::size_t>(limits_.max_points)}));
  }

  std::size_t count_of_line_ends() const {
    TextLines ahead = lines_;
    std::size_t count = 0;
    for (std::string_view line; ahead.next(line);) ++count;
    return count;
  }

  bool next_row(std::string_view& line) {
    while (lines_.next_filled(line))
      if (!is_comment(line)) return true;
    return false;
  }

  void take_row(std::string_view line) {
    std::string_view bad_cell;
    const int count = parse_row(line, separator_, values_, bad_cell);
    if (count < 0) fail_not_a_number(bad_cell);
    if (count == 1 && is_whole(values_[0]) && rows_in_block_ == block_size_ &&
        (has_blocks_ || builder_.size() == 0)) {
      begin_block(static_cast<std::uint64_t>(values_[0]));
      return;
    }
    if (count < 3) fail("the row has " + std::to_string(count) + " columns", "a point needs x, y and z");
    if (count != columns_.count)
      fail("the row has " + std::to_string(count) + " columns, those above " + std::to_string(columns_.count),
           kHintDamaged);
    if (has_blocks_ && rows_in_block_ == block_size_) fail("more points than the file counts", kHintDamaged);
    ++rows_in_block_;
    if (!has_blocks_) block_size_ = rows_in_block_;
    CloudBuilder::check_count(builder_.size() + 1, limits_, "rows");
    add_point();
  }

  void add_point() {
    const auto& v = values_;
    const Columns& c = columns_;
    builder_.add_position(v[c.position[0]], v[c.position[1]], v[c.position[2]]);
    if (c.has_normal) builder_.add_normal(v[c.normal[0]], v[c.normal[1]], v[c.normal[2]]);
    if (c.has_colour) builder_.add_colour(v[c.colour[0]], v[c.colour[1]], v[c.colour[2]]);
    if (c.confidence >= 0) builder_.add_confidence(v[c.confidence]);
  }

  void begin_block(std::uint64_t points) {
    has_blocks_ = true;
    block_size_ = points;
    rows_in_block_ = 0;
    if (points > lines_.bytes_left() / kLeastRowBytes + 1) fail_count();
  }

  [[noreturn]] void fail_count() const {
    fail("the file counts " + std::to_string(block_size_) + " points, there are " +
             std::to_string(rows_in_block_) + " and " + std::to_string(lines_.bytes_left()) + " bytes more",
         kHintCut);
  }

  [[noreturn]] void fail_not_a_number(std::string_view cell) const {
    const bool has_comma = cell.find(',') != std::string_view::npos;
    fail(quoted(cell) + " is not a number",
         has_comma ? "decimal commas are not understood: export with decimal points" : kHintDamaged);
  }

  [[noreturn]] void fail(const std::string& fault, const std::string& hint) const {
    fail_at_line(fault, lines_.number(), hint);
  }

  TextLines lines_;
  TextLines first_row_ = lines_;
  const ScanLimits& limits_;
  CloudBuilder builder_;
  Columns columns_;
  char separator_ = ' ';
  double values_[kMaxColumns] = {};
  bool has_blocks_ = false;
  std::uint64_t block_size_ = 0, rows_in_block_ = 0;
};

}  // namespace

ScanFile read_text(std::span<const std::byte> bytes, const ScanLimits& limits) {
  return TextReader(bytes, limits).read();
}

}  // namespace phiz::readers
