#include "formats/triangle_mesh.h"

#include <bit>
#include <charconv>
#include <cstring>

#include "formats/error.h"
#include "formats/text.h"

namespace phiz {
namespace {

static_assert(std::endian::native == std::endian::little, "binary files are written as they lie in memory");

template <typename Value>
void append_raw(std::string& bytes, const Value* values, std::size_t count) {
  const std::size_t old = bytes.size();
  bytes.resize(old + count * sizeof(Value));
  std::memcpy(bytes.data() + old, values, count * sizeof(Value));
}

void append_digits(std::string& text, float value) {
  char buffer[32];
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, 9);
  text += ' ';
  text.append(buffer, result.ptr);
}

template <typename Vector>
void append_line(std::string& text, const char* keyword, const Vector& vector) {
  text += keyword;
  for (float value : vector) append_digits(text, value);
}

template <typename Vector>
void check_rows(const std::vector<Vector>& rows, std::size_t count, const char* name) {
  if (!rows.empty() && rows.size() != count) {
    throw FormatError(std::to_string(rows.size()) + " " + name + " for " + std::to_string(count) +
                      " vertices");
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!rows[i].allFinite()) {
      throw FormatError(std::string(name) + " are not finite (vertex " + std::to_string(i) + ")");
    }
  }
}

}  // namespace

void check_mesh(const TriangleMesh& mesh) {
  check_rows(mesh.positions, mesh.vertex_count(), "positions");
  check_rows(mesh.normals, mesh.vertex_count(), "normals");
  check_rows(mesh.uv, mesh.vertex_count(), "uv");
  if (!mesh.colours.empty() && mesh.colours.size() != mesh.vertex_count()) {
    throw FormatError(std::to_string(mesh.colours.size()) + " colours for " +
                      std::to_string(mesh.vertex_count()) + " vertices");
  }
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    for (int corner : mesh.triangles[t]) {
      if (corner < 0 || static_cast<std::size_t>(corner) >= mesh.vertex_count()) {
        throw FormatError("corner " + std::to_string(corner) + " is no vertex (triangle " +
                          std::to_string(t) + ")");
      }
    }
  }
}

void write_ply(const TriangleMesh& mesh, std::ostream& out) {
  check_mesh(mesh);
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(mesh.vertex_count()) +
                      "\nproperty float x\nproperty float y\nproperty float z\n";
  if (!mesh.normals.empty()) bytes += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!mesh.uv.empty()) bytes += "property float s\nproperty float t\n";
  if (!mesh.colours.empty()) bytes += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  bytes += "element face " + std::to_string(mesh.triangle_count()) +
           "\nproperty list uchar int vertex_indices\nend_header\n";
  bytes.reserve(bytes.size() + mesh.vertex_count() * 35 + mesh.triangle_count() * 13);
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    append_raw(bytes, mesh.positions[i].data(), 3);
    if (!mesh.normals.empty()) append_raw(bytes, mesh.normals[i].data(), 3);
    if (!mesh.uv.empty()) append_raw(bytes, mesh.uv[i].data(), 2);
    if (!mesh.colours.empty()) append_raw(bytes, mesh.colours[i].data(), 3);
  }
  for (const Eigen::Vector3i& corners : mesh.triangles) {
    bytes += '\3';
    append_raw(bytes, corners.data(), 3);
  }
  write_all(out, bytes);
}

void write_obj(const TriangleMesh& mesh, std::ostream& out) {
  check_mesh(mesh);
  std::string text;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    append_line(text, "v", mesh.positions[i]);
    if (!mesh.colours.empty()) {
      for (std::uint8_t channel : mesh.colours[i]) append_digits(text, static_cast<float>(channel) / 255.0f);
    }
    text += '\n';
  }
  for (const Eigen::Vector2f& uv : mesh.uv) (append_line(text, "vt", uv), text += '\n');
  for (const Eigen::Vector3f& normal : mesh.normals) (append_line(text, "vn", normal), text += '\n');
  for (const Eigen::Vector3i& corners : mesh.triangles) {
    text += 'f';
    for (int corner : corners) {
      const std::string index = std::to_string(corner + 1);
      text += ' ' + index;
      if (!mesh.uv.empty()) text += '/' + index;
      if (!mesh.normals.empty()) text += (mesh.uv.empty() ? "//" : "/") + index;
    }
    text += '\n';
  }
  write_all(out, text);
}

}  // namespace phiz
