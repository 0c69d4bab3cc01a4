#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "formats/head_asset.h"

// The JSON of a head asset; head_asset.cpp fills in the streams it points to.
namespace phiz::head_asset_document {

/// A run of bytes in the BIN chunk.
struct Stream {
  std::size_t offset = 0, length = 0;
};

struct Level {
  std::size_t vertex_count = 0;  ///< of the whole level
  Stream displacements, confidences;
};

/// All that the JSON says.
struct Document {
  std::string template_digest;
  HeadAssetOptions steps;
  Eigen::Matrix4d scan_from_head = Eigen::Matrix4d::Identity();
  std::size_t vertex_count = 0, triangle_count = 0;
  Eigen::Vector3f low = Eigen::Vector3f::Zero(), high = Eigen::Vector3f::Zero();  ///< box of the positions
  bool has_confidences = false;
  Stream mesh;
  std::vector<Level> levels;
  std::size_t bin_length = 0;
};

/// Canonical text with an empty seal (64 zeros).
std::string format(const Document& document);

/// Throws FormatError with the path of the key. Streams lie within `bin_length` bytes; nothing else is known
/// of counts.
Document parse(std::string_view json, std::size_t bin_length);

/// Where the 64 digits of the seal stand in a file. Throws FormatError if there is none.
std::size_t find_seal(std::string_view bytes);
constexpr std::size_t kSealLength = 64;

}  // namespace phiz::head_asset_document
