#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>

#include "formats/error.h"
#include "formats/motion.h"
#include "formats/motion_parts.h"
#include "formats/text.h"

namespace phiz {
namespace {

constexpr double kDay = 86400;

struct Line {
  std::size_t number = 0;  ///< from 1
  std::vector<std::string_view> cells;
};

struct Table {
  std::vector<Line> rows;  ///< the first is the header
  double comment_fps = 0;  ///< of a line "# fps N"; 0: none
};

std::string place_of(const Line& line) {
  return "line " + std::to_string(line.number);
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r'))
    text.remove_suffix(1);
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
  return text;
}

Table split(std::string_view text) {
  Table table;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  std::size_t number = 0;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view whole = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    if (whole.empty()) continue;
    if (whole.starts_with("#")) {
      if (whole.starts_with("# fps ") && !parse_number(whole.substr(6), table.comment_fps))
        throw FormatError("is no rate (line " + std::to_string(number) + ")");
      continue;
    }
    Line line{number, {}};
    std::string_view rest = whole;
    while (true) {
      const std::size_t comma = rest.find(',');
      line.cells.push_back(trimmed(rest.substr(0, comma)));
      if (comma == std::string_view::npos) break;
      rest.remove_prefix(comma + 1);
    }
    table.rows.push_back(std::move(line));
  }
  return table;
}

double parse_cell(const Line& line, std::size_t column, std::string_view name) {
  double value = 0;
  if (!parse_number(line.cells[column], value) || !std::isfinite(value)) {
    throw FormatError("'" + std::string(line.cells[column].substr(0, 40)) + "' is not a finite number (" +
                      place_of(line) + ", column " + std::string(name) + ")");
  }
  return value;
}

/// HH:MM:SS:FF.sub; some devices write FF without `.sub`.
struct Timecode {
  double seconds = 0;  ///< whole, since midnight
  double frame = 0;
};

Timecode parse_timecode(const Line& line, std::size_t column) {
  std::string_view rest = line.cells[column];
  std::array<double, 4> parts{};
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t colon = i < 3 ? rest.find(':') : rest.size();
    const bool good = colon != std::string_view::npos && parse_number(rest.substr(0, colon), parts[i]) &&
                      parts[i] >= 0 && (i == 3 || parts[i] == std::floor(parts[i]));
    if (!good)
      throw FormatError("'" + std::string(line.cells[column].substr(0, 40)) +
                        "' is no timecode HH:MM:SS:FF.sub (" + place_of(line) + ")");
    rest.remove_prefix(std::min(colon + 1, rest.size()));
  }
  if (parts[0] > 47 || parts[1] > 59 || parts[2] > 60 || parts[3] >= 1000)
    throw FormatError("timecode out of range (" + place_of(line) + ")");
  return {3600 * parts[0] + 60 * parts[1] + parts[2], parts[3]};
}

/// How many frames the timecode counts in a second: from where the seconds go on by one between neighbouring
/// rows, the most frequent sum; without such a place 60, as Live Link Face counts, or more where frames do.
double find_count_per_second(const std::vector<Timecode>& codes) {
  std::vector<double> steps;
  double largest = 0;
  for (std::size_t i = 0; i < codes.size(); ++i) {
    largest = std::max(largest, codes[i].frame);
    if (i > 0 && codes[i].seconds == codes[i - 1].seconds)
      steps.push_back(codes[i].frame - codes[i - 1].frame);
  }
  std::map<int, int> votes;
  if (!steps.empty()) {
    std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2),
                     steps.end());
    const double step = steps[steps.size() / 2];
    for (std::size_t i = 1; i < codes.size(); ++i) {
      if (codes[i].seconds != codes[i - 1].seconds + 1) continue;
      const double count = std::round(codes[i - 1].frame + step - codes[i].frame);
      if (count > largest && count <= 1000) ++votes[static_cast<int>(count)];
    }
  }
  double best = largest < 60 ? 60 : std::floor(largest) + 1;
  int most = 0;
  for (const auto& [count, number] : votes) {
    if (number > most) most = number, best = count;
  }
  return best;
}

void take_timecodes(const Table& table, std::size_t column, Motion& motion) {
  std::vector<Timecode> codes;
  for (std::size_t i = 1; i < table.rows.size(); ++i) codes.push_back(parse_timecode(table.rows[i], column));
  const double count = find_count_per_second(codes);
  double start = 0, last = 0, days = 0;
  for (std::size_t i = 0; i < codes.size(); ++i) {
    double time = codes[i].seconds + codes[i].frame / count + days;
    if (i > 0 && time < last - 0.5 * kDay) time += kDay, days += kDay;
    if (i == 0) start = time;
    if (i > 0 && !(time > last))
      throw FormatError("timecode does not go on (" + place_of(table.rows[i + 1]) + ")");
    last = time;
    motion.times_s.push_back(std::round((time - start) * 1e6) / 1e6);
    if (i > 0 && !(motion.times_s[i] > motion.times_s[i - 1]))
      throw FormatError("timecode does not go on (" + place_of(table.rows[i + 1]) + ")");
  }
}

void take_times(const Table& table, std::size_t column, bool are_frames, Motion& motion) {
  if (are_frames && !(table.comment_fps > 0 && table.comment_fps <= 1000))
    throw FormatError("column 'frame' needs a rate", "put a line '# fps 30' first, or a column time_s");
  for (std::size_t i = 1; i < table.rows.size(); ++i) {
    const double number = parse_cell(table.rows[i], column, are_frames ? "frame" : "time_s");
    const double time = are_frames ? number / table.comment_fps : number;
    if (!motion.times_s.empty() && !(time > motion.times_s.back()))
      throw FormatError("time does not go on (" + place_of(table.rows[i]) + ")");
    motion.times_s.push_back(time);
  }
}

}  // namespace

namespace motion_parts {

std::string exact_text(float value) {
  std::array<char, 64> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value + 0.0f);
  return {digits.data(), end};
}

Motion parse_csv(const std::string& text) {
  const Table table = split(text);
  if (table.rows.empty()) throw FormatError("has no header line");
  const Line& header = table.rows.front();
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::size_t timecode = kNone, time = kNone, frame = kNone;
  Motion motion;
  std::vector<std::size_t> columns;
  for (std::size_t c = 0; c < header.cells.size(); ++c) {
    const std::string name(header.cells[c]);
    const bool is_time = name == "Timecode" || name == "time_s" || name == "frame";
    if (is_time && (timecode != kNone || time != kNone || frame != kNone))
      throw FormatError("has two columns of time (" + place_of(header) + ")");
    if (name == "Timecode") timecode = c;
    if (name == "time_s") time = c;
    if (name == "frame") frame = c;
    if (is_time || name == "BlendShapeCount") continue;
    if (!is_name(name))
      throw FormatError("column " + std::to_string(c + 1) + " has no usable name (" + place_of(header) + ")");
    motion.names.push_back(name);
    columns.push_back(c);
  }
  if (timecode == kNone && time == kNone && frame == kNone) {
    throw FormatError("has no column Timecode, time_s or frame (" + place_of(header) + ")",
                      "a Live Link Face CSV begins with Timecode,BlendShapeCount");
  }
  for (const Line& line : table.rows) {
    if (line.cells.size() != header.cells.size())
      throw FormatError("has " + std::to_string(line.cells.size()) + " columns, the header " +
                        std::to_string(header.cells.size()) + " (" + place_of(line) + ")");
  }
  if (timecode != kNone)
    take_timecodes(table, timecode, motion);
  else
    take_times(table, time != kNone ? time : frame, time == kNone, motion);
  for (std::size_t i = 1; i < table.rows.size(); ++i) {
    for (std::size_t k = 0; k < columns.size(); ++k)
      motion.values.push_back(
          to_value(parse_cell(table.rows[i], columns[k], motion.names[k]), place_of(table.rows[i])));
  }
  check_motion(motion);
  find_rate_and_gaps(motion);
  if (table.comment_fps > 0) motion.frames_per_second = table.comment_fps;
  return motion;
}

}  // namespace motion_parts

void write_motion_csv(const Motion& motion, std::ostream& out) {
  check_motion(motion);
  std::array<char, 64> digits;
  const auto exact = [&digits](double value) {
    return std::string(digits.data(),
                       std::to_chars(digits.data(), digits.data() + digits.size(), value + 0.0).ptr);
  };
  std::string text = "# fps " + exact(motion.frames_per_second) + "\ntime_s";
  for (const std::string& name : motion.names) text.append(",").append(name);
  for (std::size_t i = 0; i < motion.frame_count(); ++i) {
    text.append("\n").append(exact(motion.times_s[i]));
    for (const float value : motion.frame(i)) text.append(",").append(motion_parts::exact_text(value));
  }
  write_all(out, text + "\n");
}

}  // namespace phiz
