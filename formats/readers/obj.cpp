// Wavefront OBJ: what a scan needs of it. Vertex colours behind the position are the common extension.
#include <charconv>
#include <limits>

#include "formats/readers/cloud_builder.h"
#include "formats/readers/fail.h"
#include "formats/readers/readers.h"
#include "formats/readers/text_lines.h"

namespace phiz::readers {
namespace {

struct Corner {
  int vertex_idx = 0;
  int normal_idx = -1;  ///< -1: none
};

struct LineCounts {
  std::size_t vertices = 0, normals = 0, faces = 0;
};

LineCounts count_lines(std::span<const std::byte> bytes) {
  LineCounts counts;
  TextLines lines(bytes);
  std::string_view line;
  while (lines.next(line)) {
    counts.vertices += line.starts_with("v ") || line.starts_with("v\t");
    counts.normals += line.starts_with("vn");
    counts.faces += line.starts_with("f ") || line.starts_with("f\t");
  }
  return counts;
}

class ObjReader {
 public:
  ObjReader(std::span<const std::byte> bytes, const ScanLimits& limits) : lines_(bytes), limits_(limits) {
    const LineCounts counts = count_lines(bytes);
    CloudBuilder::check_count(counts.vertices, limits_, "v lines");
    builder_.reserve(counts.vertices);
    builder_.scan.triangles.reserve(counts.faces);
    file_normals_.reserve(counts.normals);
  }

  ScanFile read() {
    std::string_view line;
    while (next_statement(line)) {
      Fields fields(line, lines_.number());
      const std::string_view keyword = fields.next_word();
      if (keyword == "v")
        read_vertex(fields);
      else if (keyword == "f" || keyword == "fo")
        read_face(fields);
      else if (keyword == "vn")
        read_normal(fields);
      else
        check_keyword(keyword);
    }
    check_indices();
    give_normals();
    return builder_.finish("obj", ColourRange::numbers);
  }

 private:
  /// A line, with the ones it goes on in ("\" at the end) joined to it.
  bool next_statement(std::string_view& line) {
    if (!lines_.next_filled(line)) return false;
    if (line.back() != '\\' || line.front() == '#') return true;
    joined_.clear();
    bool goes_on = true;
    while (goes_on) {
      goes_on = !line.empty() && line.back() == '\\';
      joined_.append(line.substr(0, line.size() - (goes_on ? 1 : 0)));
      joined_ += ' ';
      if (goes_on && !lines_.next(line)) break;
    }
    line = joined_;
    return true;
  }

  void read_vertex(Fields& fields) {
    double values[8];
    int count = 0;
    while (count < 8 && fields.next_number(values[count])) ++count;
    if (count < 3) fail_at_line("a vertex has less than three coordinates", lines_.number(), kHintCut);
    if (count == 8) fail_at_line("a vertex has more than seven numbers", lines_.number(), kHintDamaged);
    const bool has_colour = count >= 6;  // x y z r g b [a]
    if (has_colour && colour_count_++ == builder_.size())
      builder_.add_colour(values[3], values[4], values[5]);
    builder_.add_position(values[0], values[1], values[2]);
  }

  void read_normal(Fields& fields) {
    const double x = fields.number("nx"), y = fields.number("ny"), z = fields.number("nz");
    file_normals_.emplace_back(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
  }

  void read_face(Fields& fields) {
    corners_.clear();
    for (std::string_view word = fields.next_word(); !word.empty(); word = fields.next_word())
      corners_.push_back(parse_corner(word));
    if (corners_.empty()) fail_at_line("a face has no vertices", lines_.number(), kHintCut);
    for (std::size_t k = 2; k < corners_.size(); ++k)
      builder_.scan.triangles.emplace_back(corners_[0].vertex_idx, corners_[k - 1].vertex_idx,
                                           corners_[k].vertex_idx);
    for (const Corner& corner : corners_) {
      note_largest(corner.vertex_idx, largest_vertex_);
      if (corner.normal_idx >= 0) add_corner_normal(corner);
    }
  }

  /// The normal must stand before the face in the file, as all known writers have it; else it is left out.
  void add_corner_normal(const Corner& corner) {
    if (static_cast<std::size_t>(corner.normal_idx) >= file_normals_.size()) return;
    if (static_cast<std::size_t>(corner.vertex_idx) >= builder_.size()) return;
    if (normal_sums_.size() < builder_.size()) normal_sums_.resize(builder_.size(), Eigen::Vector3f::Zero());
    normal_sums_[corner.vertex_idx] += file_normals_[corner.normal_idx];
  }

  struct Largest {
    int idx = -1;
    std::uint64_t line = 0;
  };

  void note_largest(int idx, Largest& largest) const {
    if (idx > largest.idx) largest = {idx, lines_.number()};
  }

  /// v, v/vt, v//vn or v/vt/vn
  Corner parse_corner(std::string_view word) {
    Corner corner;
    const std::size_t slash = word.find('/');
    corner.vertex_idx = parse_index(word.substr(0, slash), word, builder_.size());
    if (slash == std::string_view::npos) return corner;
    const std::string_view rest = word.substr(slash + 1);
    const std::size_t second = rest.find('/');
    if (!rest.substr(0, second).empty()) parse_integer(rest.substr(0, second), word);
    if (second != std::string_view::npos && second + 1 < rest.size())
      corner.normal_idx = parse_index(rest.substr(second + 1), word, file_normals_.size());
    return corner;
  }

  long parse_integer(std::string_view text, std::string_view word) const {
    long value = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || stop != text.data() + text.size())
      fail_at_line(quoted(word) + " is not a corner of a face", lines_.number(), kHintDamaged);
    return value;
  }

  /// From 1, or counted back from the latest.
  int parse_index(std::string_view text, std::string_view word, std::size_t count) const {
    const long value = parse_integer(text, word);
    const long idx = value < 0 ? static_cast<long>(count) + value : value - 1;
    if (value == 0 || idx < 0 || idx >= std::numeric_limits<int>::max())
      fail_at_line(quoted(word) + " names a vertex that is not there", lines_.number(), kHintDamaged);
    return static_cast<int>(idx);
  }

  /// Any word may be an extension; what is not a word is damage.
  void check_keyword(std::string_view keyword) const {
    if (keyword.empty() || keyword.front() == '#') return;
    for (const char c : keyword)
      if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
            c == '-'))
        fail_at_line(quoted(keyword) + " is no OBJ keyword", lines_.number(), kHintDamaged);
  }

  void check_indices() const {
    if (largest_vertex_.idx >= static_cast<long>(builder_.size()))
      fail_at_line("a face names vertex " + std::to_string(largest_vertex_.idx + 1L) + " of " +
                       std::to_string(builder_.size()),
                   largest_vertex_.line, kHintCut);
  }

  void give_normals() {
    if (normal_sums_.empty() && file_normals_.size() == builder_.size()) normal_sums_.swap(file_normals_);
    file_normals_ = {};
    if (normal_sums_.empty()) return;
    normal_sums_.resize(builder_.size(), Eigen::Vector3f::Zero());
    builder_.scan.points.normals.reserve(normal_sums_.size());
    for (const Eigen::Vector3f& n : normal_sums_) builder_.add_normal(n.x(), n.y(), n.z());
  }

  TextLines lines_;
  const ScanLimits& limits_;
  CloudBuilder builder_;
  std::vector<Eigen::Vector3f> file_normals_, normal_sums_;
  std::vector<Corner> corners_;
  std::string joined_;
  Largest largest_vertex_;
  std::size_t colour_count_ = 0;
};

}  // namespace

ScanFile read_obj(std::span<const std::byte> bytes, const ScanLimits& limits) {
  return ObjReader(bytes, limits).read();
}

}  // namespace phiz::readers
