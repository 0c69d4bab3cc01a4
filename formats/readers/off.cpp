// Geomview's Object File Format: OFF, with C (colours), N (normals) and ST (texture) in front; text only.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "formats/readers/cloud_builder.h"
#include "formats/readers/fail.h"
#include "formats/readers/readers.h"
#include "formats/readers/text_lines.h"

namespace phiz::readers {
namespace {

class OffReader {
 public:
  OffReader(std::span<const std::byte> bytes, const ScanLimits& limits) : lines_(bytes), limits_(limits) {}

  ScanFile read() {
    read_head();
    builder_.reserve(vertex_count_);
    for (std::uint64_t i = 0; i < vertex_count_; ++i) read_vertex();
    constexpr std::size_t kLeastFaceBytes = 8;  // "3 0 1 2"
    builder_.scan.triangles.reserve(
        std::min<std::uint64_t>(face_count_, lines_.bytes_left() / kLeastFaceBytes + 1));
    for (std::uint64_t i = 0; i < face_count_; ++i) read_face();
    return builder_.finish("off", ColourRange::numbers);
  }

 private:
  /// The keyword, then the numbers of vertices, faces and edges, on the same line or on the next.
  void read_head() {
    std::string_view line = next_line("OFF");
    const std::size_t keyword_end = line.find("OFF") == std::string_view::npos ? 0 : line.find("OFF") + 3;
    for (const char c : line.substr(0, keyword_end)) {
      has_normals_ |= c == 'N';
      has_colours_ |= c == 'C';
      if (c == '4' || c == 'n')
        fail(quoted(line.substr(0, keyword_end)) + " is not in three dimensions", "export as plain OFF");
    }
    if (keyword_end == 0) fail("does not begin with OFF", "is it another format under this name?");
    line.remove_prefix(keyword_end);
    Fields rest(line, lines_.number());
    if (line.find("BINARY") != std::string_view::npos) fail("is binary OFF", "export as text, or as PLY");
    if (rest.at_end()) line = next_line("the line of counts");
    Fields fields(line, lines_.number());
    vertex_count_ = count(fields.number("the number of vertices"));
    face_count_ = count(fields.number("the number of faces"));
    CloudBuilder::check_count(vertex_count_, limits_);
    const std::uint64_t there = (lines_.bytes_left() + 1) / 6;
    if (vertex_count_ > there || face_count_ > (lines_.bytes_left() + 1) / 2)
      fail("the header says " + std::to_string(vertex_count_) + " vertices and " +
               std::to_string(face_count_) + " faces, there are bytes for " + std::to_string(there) +
               " vertices at most",
           kHintCut);
  }

  /// The next line that says something, without its comment.
  std::string_view next_line(const char* meaning) {
    std::string_view line;
    while (lines_.next_filled(line)) {
      line = line.substr(0, line.find('#'));
      Fields fields(line, lines_.number());
      if (!fields.at_end()) return line;
    }
    fail(std::string(meaning) + " is missing", kHintCut);
  }

  void read_vertex() {
    const std::string_view line = next_line("a vertex");
    Fields fields(line, lines_.number());
    const double x = fields.number("x"), y = fields.number("y"), z = fields.number("z");
    builder_.add_position(x, y, z);
    if (has_normals_) {
      const double nx = fields.number("nx"), ny = fields.number("ny"), nz = fields.number("nz");
      builder_.add_normal(nx, ny, nz);
    }
    if (has_colours_) {
      const double r = fields.number("red"), g = fields.number("green"), b = fields.number("blue");
      builder_.add_colour(r, g, b);
    }
    for (double ignored = 0.0; fields.next_number(ignored);) {
    }
  }

  void read_face() {
    const std::string_view line = next_line("a face");
    Fields fields(line, lines_.number());
    const std::uint64_t corners = count(fields.number("the number of corners"));
    int first = 0, previous = 0;
    for (std::uint64_t k = 0; k < corners; ++k) {
      const std::uint64_t idx = count(fields.number("a corner"));
      if (idx >= vertex_count_)
        fail("a face names vertex " + std::to_string(idx) + " of " + std::to_string(vertex_count_),
             kHintDamaged);
      const int corner = static_cast<int>(idx);
      if (k == 0) first = corner;
      if (k >= 2) builder_.scan.triangles.emplace_back(first, previous, corner);
      previous = corner;
    }
  }

  std::uint64_t count(double value) const {
    if (!(value >= 0.0 && value < 1e15) || value != std::floor(value))
      fail("a count is not a whole number", kHintDamaged);
    return static_cast<std::uint64_t>(value);
  }

  [[noreturn]] void fail(const std::string& fault, const std::string& hint) const {
    fail_at_line(fault, lines_.number(), hint);
  }

  TextLines lines_;
  const ScanLimits& limits_;
  CloudBuilder builder_;
  std::uint64_t vertex_count_ = 0, face_count_ = 0;
  bool has_normals_ = false, has_colours_ = false;
};

}  // namespace

ScanFile read_off(std::span<const std::byte> bytes, const ScanLimits& limits) {
  return OffReader(bytes, limits).read();
}

}  // namespace phiz::readers
