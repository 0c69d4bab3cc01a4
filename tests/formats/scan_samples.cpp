#include "tests/formats/scan_samples.h"

#include <algorithm>
#include <charconv>
#include <cstring>

#include "formats/error.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz::test {
namespace {

template <typename Number>
std::string bytes_of(Number value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

std::string row_of(const Eigen::Vector3f& v) {
  return text_of(v.x()) + " " + text_of(v.y()) + " " + text_of(v.z());
}

std::string row_of(const std::array<std::uint8_t, 3>& c, const std::string& separator = " ") {
  return std::to_string(c[0]) + separator + std::to_string(c[1]) + separator + std::to_string(c[2]);
}

std::string bytes_of(const Eigen::Vector3f& v) {
  return bytes_of(v.x()) + bytes_of(v.y()) + bytes_of(v.z());
}

}  // namespace

ScanSample make_sample() {
  const TriangleMesh sphere = icosphere(1);
  ScanSample sample;
  sample.triangles = sphere.triangles;
  for (const Eigen::Vector3f& p : sphere.positions) {
    sample.positions.push_back(p * static_cast<float>(random().uniform(90.0, 110.0)));
    sample.normals.push_back(p);
    sample.colours.push_back({static_cast<std::uint8_t>(random().below(256)),
                              static_cast<std::uint8_t>(random().below(256)),
                              static_cast<std::uint8_t>(random().below(256))});
    sample.confidences.push_back(static_cast<float>(random().below(65)) / 64.0f);
  }
  sample.colours[0] = {255, 0, 255};
  return sample;
}

ScanFile parse(const std::string& bytes, const std::string& extension, const ScanLimits& limits) {
  return parse_scan(std::as_bytes(std::span(bytes)), extension, limits);
}

std::string fault_of(const std::string& bytes, const std::string& extension, const ScanLimits& limits) {
  try {
    parse(bytes, extension, limits);
  } catch (const FormatError& error) {
    return std::string(error.what()) + " | " + error.hint();
  }
  return {};
}

std::vector<Eigen::Vector3d> true_positions(const ScanFile& scan) {
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& p : scan.points.positions) positions.push_back(scan.origin + p.cast<double>());
  return positions;
}

std::string text_of(float value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

std::string ply_number(PlyKind kind, const std::string& type, double value) {
  std::string bytes;
  if (type == "char" || type == "int8") bytes = bytes_of(static_cast<std::int8_t>(value));
  if (type == "uchar" || type == "uint8") bytes = bytes_of(static_cast<std::uint8_t>(value));
  if (type == "short" || type == "int16") bytes = bytes_of(static_cast<std::int16_t>(value));
  if (type == "ushort" || type == "uint16") bytes = bytes_of(static_cast<std::uint16_t>(value));
  if (type == "int" || type == "int32") bytes = bytes_of(static_cast<std::int32_t>(value));
  if (type == "uint" || type == "uint32") bytes = bytes_of(static_cast<std::uint32_t>(value));
  if (type == "float" || type == "float32") bytes = bytes_of(static_cast<float>(value));
  if (type == "double" || type == "float64") bytes = bytes_of(value);
  if (kind == PlyKind::big) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

std::string write_ply_as(PlyKind kind, const std::vector<PlyColumn>& columns,
                         const std::vector<Eigen::Vector3i>& triangles, int list_at) {
  static const char* const kNames[] = {"ascii", "binary_little_endian", "binary_big_endian"};
  const std::size_t rows = columns[0].values.size();
  std::string head = std::string("ply\nformat ") + kNames[static_cast<int>(kind)] +
                     " 1.0\ncomment made by a test\n" + "obj_info none\nelement vertex " +
                     std::to_string(rows) + "\n";
  const auto list_line = [&](std::size_t k) {
    return static_cast<int>(k) == list_at ? "property list uchar short extra\n" : "";
  };
  for (std::size_t k = 0; k < columns.size(); ++k)
    head += list_line(k) + ("property " + columns[k].type + " " + columns[k].name + "\n");
  head += list_line(columns.size());
  if (!triangles.empty())
    head += "element face " + std::to_string(triangles.size()) + "\nproperty list uchar int vertex_indices\n";
  std::string body;
  const auto put = [&](const std::string& type, double value) {
    if (kind != PlyKind::ascii) {
      body += ply_number(kind, type, value);
      return;
    }
    std::array<char, 32> text{};
    char* end = text.data() + text.size();
    const bool is_float = type == "float";
    body.append(text.data(), is_float ? std::to_chars(text.data(), end, static_cast<float>(value)).ptr
                                      : std::to_chars(text.data(), end, value).ptr);
    body += ' ';
  };
  const auto put_list = [&](std::size_t row, std::size_t k) {
    if (static_cast<int>(k) != list_at) return;
    put("uchar", static_cast<double>(row % 4));
    for (std::size_t i = 0; i < row % 4; ++i) put("short", static_cast<double>(i));
  };
  const auto end_row = [&] {
    if (kind == PlyKind::ascii) body.back() = '\n';
  };
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t k = 0; k < columns.size(); ++k) {
      put_list(row, k);
      put(columns[k].type, columns[k].values[row]);
    }
    put_list(row, columns.size());
    end_row();
  }
  for (const Eigen::Vector3i& t : triangles) {
    put("uchar", 3);
    for (const int corner : t) put("int", corner);
    end_row();
  }
  return head + "end_header\n" + body;
}

std::vector<PlyColumn> ply_columns(const ScanSample& sample) {
  std::vector<PlyColumn> columns;
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "confidence"})
    columns.push_back({name, "float", {}});
  for (const char* name : {"red", "green", "blue"}) columns.push_back({name, "uchar", {}});
  for (std::size_t i = 0; i < sample.positions.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      columns[k].values.push_back(static_cast<double>(sample.positions[i][static_cast<int>(k)]));
      columns[3 + k].values.push_back(static_cast<double>(sample.normals[i][static_cast<int>(k)]));
      columns[7 + k].values.push_back(sample.colours[i][k]);
    }
    columns[6].values.push_back(static_cast<double>(sample.confidences[i]));
  }
  return columns;
}

std::string write_obj_text(const ScanSample& sample) {
  std::string text = "# made by a test\nmtllib none.mtl\no head\n";
  for (std::size_t i = 0; i < sample.positions.size(); ++i) {
    text += "v " + row_of(sample.positions[i]);
    for (const std::uint8_t c : sample.colours[i]) (text += ' ') += text_of(static_cast<float>(c) / 255.0f);
    text += "\n";
  }
  for (const Eigen::Vector3f& n : sample.normals) text += "vn " + row_of(n) + "\n";
  for (const Eigen::Vector3i& t : sample.triangles) {
    text += "f";
    for (const int corner : t)
      text.append(1, ' ').append(std::to_string(corner + 1)).append("//").append(std::to_string(corner + 1));
    text += "\n";
  }
  return text;
}

std::string write_stl_text(const ScanSample& sample) {
  std::string text = "solid a head with facets\n";
  for (const Eigen::Vector3i& t : sample.triangles) {
    text += " facet normal 0 0 1\n  outer loop\n";
    for (const int corner : t)
      text += "   vertex " + row_of(sample.positions[static_cast<std::size_t>(corner)]) + "\n";
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid\n";
}

std::string write_stl_binary(const ScanSample& sample) {
  std::string bytes = "solid in name only";
  bytes.resize(80, '\0');
  bytes += bytes_of(static_cast<std::uint32_t>(sample.triangles.size()));
  for (const Eigen::Vector3i& t : sample.triangles) {
    bytes += bytes_of(Eigen::Vector3f(0.0f, 0.0f, 1.0f));
    for (const int corner : t) bytes += bytes_of(sample.positions[static_cast<std::size_t>(corner)]);
    bytes += std::string(2, '\0');
  }
  return bytes;
}

std::string write_off_text(const ScanSample& sample) {
  std::string text = "CNOFF\n# made by a test\n" + std::to_string(sample.positions.size()) + " " +
                     std::to_string(sample.triangles.size()) + " 0\n";
  for (std::size_t i = 0; i < sample.positions.size(); ++i)
    text += row_of(sample.positions[i]) + " " + row_of(sample.normals[i]) + " " + row_of(sample.colours[i]) +
            " 255\n";
  for (const Eigen::Vector3i& t : sample.triangles)
    text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
  return text;
}

std::string write_columns(const ScanSample& sample, const std::string& separator) {
  std::string text;
  const auto put = [&](const Eigen::Vector3f& v) {
    for (const float value : v) text += text_of(value) + separator;
  };
  for (std::size_t i = 0; i < sample.positions.size(); ++i) {
    put(sample.positions[i]);
    text += row_of(sample.colours[i], separator) + separator;
    put(sample.normals[i]);
    text.resize(text.size() - separator.size());
    text += "\n";
  }
  return text;
}

std::string glb_of(std::string json, std::string binary) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  const auto number = [](std::size_t value) { return bytes_of(static_cast<std::uint32_t>(value)); };
  std::string bytes = "glTF" + number(2) + number(12 + 8 + json.size() + 8 + binary.size());
  bytes += number(json.size()) + "JSON" + json;
  return bytes + number(binary.size()) + std::string("BIN\0", 4) + binary;
}

std::string write_glb(const ScanSample& sample) {
  std::string binary;
  const std::size_t points = sample.positions.size();
  for (std::size_t i = 0; i < points; ++i) {  // interleaved: 28 bytes a vertex
    binary += bytes_of(sample.positions[i]) + bytes_of(sample.normals[i]);
    for (const std::uint8_t c : sample.colours[i]) binary += static_cast<char>(c);
    binary += '\xFF';
  }
  for (const Eigen::Vector3i& t : sample.triangles)
    for (const int corner : t) binary += bytes_of(static_cast<std::uint16_t>(corner));
  const std::string count = std::to_string(points), corners = std::to_string(3 * sample.triangles.size());
  const std::string split = std::to_string(28 * points);
  const std::string vertex = R"({"bufferView":0,"count":)" + count + ",";
  const std::string json =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"buffers":[{"byteLength":)" +
      std::to_string(binary.size()) + R"(}],"bufferViews":[{"buffer":0,"byteLength":)" + split +
      R"(,"byteStride":28},{"buffer":0,"byteOffset":)" + split + R"(,"byteLength":)" +
      std::to_string(6 * sample.triangles.size()) + R"(}],"accessors":[)" + vertex +
      R"("byteOffset":0,"componentType":5126,"type":"VEC3"},)" + vertex +
      R"("byteOffset":12,"componentType":5126,"type":"VEC3"},)" + vertex +
      R"("byteOffset":24,"componentType":5121,"normalized":true,"type":"VEC4"},{"bufferView":1,"count":)" +
      corners +
      R"(,"componentType":5123,"type":"SCALAR"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,)" +
      R"("COLOR_0":2},"indices":3}]}]})";
  return glb_of(json, binary);
}

}  // namespace phiz::test
