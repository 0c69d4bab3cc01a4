#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "formats/head_asset.h"

// The JSON of a head asset; head_asset.cpp fills in the streams it points to.
namespace phiz::head_asset_document {

/// A run of bytes in the BIN chunk.
struct Stream {
  std::size_t offset = 0, length = 0;
  std::uint32_t sum = 0;  ///< CRC-32; not in schema 1
  std::size_t end() const { return offset + length; }
};

struct Level {
  std::size_t vertex_count = 0;  ///< of the whole level
  double step_mm = 0;
  Stream displacements, confidences;
};

/// All that the JSON says.
struct Document {
  int schema = 2;
  std::string template_digest;
  double position_step_mm = 0.01, tolerance_mm = 0;
  int texture_steps = 65535, confidence_step = 1;
  Eigen::Matrix4d scan_from_head = Eigen::Matrix4d::Identity();
  std::map<std::string, std::string> provenance;
  std::size_t vertex_count = 0, triangle_count = 0;  ///< of the control mesh
  Stream mesh, texture;                              ///< in schema 1 the mesh holds the (u,v) too
  std::vector<Level> levels;
  bool has_confidences = false;
  // The primitive of viewers that do not know the extension; at level 0 the control mesh itself.
  Stream shown;
  int shown_level = 0;
  std::size_t shown_vertex_count = 0, shown_triangle_count = 0;
  Eigen::Vector3f low = Eigen::Vector3f::Zero(), high = Eigen::Vector3f::Zero();  ///< its box
  std::size_t bin_length = 0;
};

/// Canonical text of schema 2 with an empty seal (64 zeros).
std::string format(const Document& document);

/// Throws FormatError with the path of the key. Streams lie within `bin_length` bytes; nothing else is known
/// of counts.
Document parse(std::string_view json, std::size_t bin_length);

/// Where the 64 digits of the seal stand in a file. Throws FormatError if there is none.
std::size_t find_seal(std::string_view bytes);
constexpr std::size_t kSealLength = 64;

/// Letters, digits and -_:. , at most 128 of them. Throws FormatError.
void check_name(const std::string& name, const char* what);

}  // namespace phiz::head_asset_document
