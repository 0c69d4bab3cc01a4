#include <algorithm>
#include <array>
#include <string_view>

#include "formats/control_mesh_parts.h"
#include "formats/error.h"
#include "formats/text.h"

namespace phiz::control_mesh_parts {
namespace {

constexpr int kDecimals = 6;

[[noreturn]] void fail(const std::string& what, int line_number) {
  throw FormatError(what + " (line " + std::to_string(line_number) + ")");
}

std::string quoted(std::string_view word) {
  return std::string("'").append(word).append("'");
}

/// The next word of a line, empty at its end.
std::string_view next_word(std::string_view& line) {
  const std::size_t begin = line.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return line = {};
  const std::size_t end = std::min(line.find_first_of(" \t", begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

template <typename Vector>
Vector parse_vector(std::string_view line, int line_number) {
  Vector vector;
  for (int k = 0; k < vector.size(); ++k) {
    const std::string_view word = next_word(line);
    if (word.empty()) fail("expected " + std::to_string(vector.size()) + " numbers", line_number);
    if (!parse_number(word, vector[k])) fail(quoted(word) + " is not a number", line_number);
  }
  if (!next_word(line).empty()) fail("more than " + std::to_string(vector.size()) + " numbers", line_number);
  return vector;
}

/// `a/a b/b c/c`, each optionally with `/n`.
Eigen::Vector3i parse_face(std::string_view line, int line_number) {
  Eigen::Vector3i corners;
  for (int& corner : corners) {
    const std::string_view word = next_word(line);
    if (word.empty()) fail("a face needs three corners", line_number);
    const std::string_view vertex = word.substr(0, word.find('/'));
    std::string_view texture =
        vertex.size() < word.size() ? word.substr(vertex.size() + 1) : std::string_view{};
    texture = texture.substr(0, texture.find('/'));
    int texture_idx = 0;
    if (!parse_number(vertex, corner) || corner < 1 || !parse_number(texture, texture_idx)) {
      fail(quoted(word) + " is not vertex/texture, counted from 1", line_number);
    }
    if (texture_idx != corner) fail("vt and v differ in " + quoted(word), line_number);
    --corner;
  }
  if (!next_word(line).empty()) fail("a face has more than three corners", line_number);
  return corners;
}

bool is_ignored(std::string_view keyword) {
  constexpr std::array<std::string_view, 6> kIgnored{"vn", "o", "g", "s", "mtllib", "usemtl"};
  return keyword.empty() || keyword.front() == '#' ||
         std::find(kIgnored.begin(), kIgnored.end(), keyword) != kIgnored.end();
}

template <typename Vector>
void append_line(std::string& text, const char* keyword, const Vector& vector) {
  text += keyword;
  for (double value : vector) {
    text += ' ';
    append_fixed(text, value, kDecimals, false);
  }
  text += '\n';
}

}  // namespace

ControlMesh parse_obj(const std::string& text) {
  ControlMesh mesh;
  std::string_view rest = text;
  for (int line_number = 1; !rest.empty(); ++line_number) {
    const std::size_t end = rest.find('\n');
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    const std::string_view keyword = next_word(line);
    if (keyword == "v") {
      mesh.positions.push_back(parse_vector<Eigen::Vector3d>(line, line_number));
    } else if (keyword == "vt") {
      mesh.uv.push_back(parse_vector<Eigen::Vector2d>(line, line_number));
    } else if (keyword == "f") {
      mesh.triangles.push_back(parse_face(line, line_number));
    } else if (!is_ignored(keyword)) {
      fail(quoted(keyword) + " has no place in a control mesh", line_number);
    }
  }
  return mesh;
}

std::string format_obj(const ControlMesh& mesh) {
  std::string text =
      "# phiz control mesh: mm, +y up, +z out of the face; vt = (u,v) of the vertex of the same index\n";
  for (const Eigen::Vector3d& position : mesh.positions) append_line(text, "v", position);
  for (const Eigen::Vector2d& uv : mesh.uv) append_line(text, "vt", uv);
  for (const Eigen::Vector3i& corners : mesh.triangles) {
    text += 'f';
    for (int corner : corners) {
      const std::string index = std::to_string(corner + 1);
      text += ' ' + index + '/' + index;
    }
    text += '\n';
  }
  return text;
}

}  // namespace phiz::control_mesh_parts
