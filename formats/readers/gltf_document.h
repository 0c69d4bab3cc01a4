#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/readers/draco_geometry.h"

namespace phiz::readers {

/// What a scan needs of a .glb file, taken from its JSON. Indices are -1 where there is nothing and are in
/// range otherwise; offsets and counts are as written: GltfNumbers checks them.

struct GltfView {
  std::uint64_t byte_offset = 0, byte_length = 0, byte_stride = 0;  ///< in the binary chunk; stride 0: none
  std::string unusable;  ///< why its bytes cannot be had, empty if they can
};

struct GltfAccessor {
  int view_idx = -1;
  std::uint64_t byte_offset = 0, count = 0;
  int component_type = 0;  ///< 5120 .. 5126
  int components = 0;      ///< 1 for SCALAR .. 4 for VEC4, 0 for anything else
  bool is_normalized = false;
  bool is_sparse = false;
};

struct GltfDraco {
  int view_idx = -1;
  DracoAttributeIds ids;
};

struct GltfPrimitive {
  int mode = 4;
  int position_idx = -1, normal_idx = -1, colour_idx = -1, indices_idx = -1;  ///< accessors
  std::optional<GltfDraco> draco;
};

struct GltfNode {
  Eigen::Matrix4d parent_from_node = Eigen::Matrix4d::Identity();
  int mesh_idx = -1;
  std::vector<int> children;
};

struct GltfDocument {
  std::vector<GltfView> views;
  std::vector<GltfAccessor> accessors;
  std::vector<std::vector<GltfPrimitive>> meshes;
  std::vector<GltfNode> nodes;
  std::vector<int> roots;  ///< of the default scene
  std::span<const std::byte> binary;
  std::size_t binary_byte = 0;  ///< where `binary` stands in the file
};

/// Throws FormatError. Buffers outside the file are noted in the views, not read.
GltfDocument parse_glb(std::span<const std::byte> bytes);

/// The bytes of a view. Throws FormatError if they are outside the file.
std::span<const std::byte> bytes_of_view(const GltfDocument& document, int view_idx);

/// The numbers of an accessor, checked to lie within the file.
class GltfNumbers {
 public:
  /// Throws FormatError; `least_components` is what the caller will ask for.
  GltfNumbers(const GltfDocument& document, int accessor_idx, int least_components);

  std::uint64_t size() const { return accessor_->count; }
  /// Normalised integers become [0,1] or [-1,1].
  double at(std::uint64_t row, int component) const;
  Eigen::Vector3d row(std::uint64_t idx) const { return {at(idx, 0), at(idx, 1), at(idx, 2)}; }

 private:
  const GltfAccessor* accessor_;
  const std::byte* first_ = nullptr;
  std::size_t stride_ = 0, component_bytes_ = 0;
};

}  // namespace phiz::readers
