// Binary glTF 2.0 (Khronos 2021) as a scan: the triangles and points of the default scene, in its frame.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "formats/readers/cloud_builder.h"
#include "formats/readers/draco_geometry.h"
#include "formats/readers/fail.h"
#include "formats/readers/gltf_document.h"
#include "formats/readers/readers.h"

namespace phiz::readers {
namespace {

enum Mode { kTriangles = 4, kTriangleStrip = 5, kTriangleFan = 6 };

/// glTF's colours are linear, ours sRGB (IEC 61966-2-1).
std::uint8_t to_srgb_byte(double linear) {
  if (!(linear > 0.0)) return 0;
  const double srgb = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::min(srgb * 255.0 + 0.5, 255.0));
}

/// A node's frame in the scene.
struct Placement {
  Eigen::Matrix4d scene_from_node = Eigen::Matrix4d::Identity();
  Eigen::Matrix3d normals = Eigen::Matrix3d::Identity();
  bool is_mirrored = false;

  explicit Placement(const Eigen::Matrix4d& matrix) : scene_from_node(matrix) {
    const Eigen::Matrix3d linear = matrix.topLeftCorner<3, 3>();
    const Eigen::Vector3d x = linear.col(0), y = linear.col(1), z = linear.col(2);
    is_mirrored = x.dot(y.cross(z)) < 0.0;
    normals.col(0) = y.cross(z);  // cofactors: the inverse transpose without its division
    normals.col(1) = z.cross(x);
    normals.col(2) = x.cross(y);
    if (is_mirrored) normals = -normals;
  }
};

class GlbReader {
 public:
  GlbReader(std::span<const std::byte> bytes, const ScanLimits& limits)
      : document_(parse_glb(bytes)), limits_(limits), file_bytes_(bytes.size()) {}

  ScanFile read() {
    if (document_.nodes.empty())
      for (const auto& mesh : document_.meshes) add_mesh(mesh, Placement(Eigen::Matrix4d::Identity()));
    walk_nodes();
    return builder_.finish("glb");
  }

 private:
  struct Visit {
    int node_idx;
    Eigen::Matrix4d scene_from_parent;
  };

  /// Depth first, children in order; without recursion, as the depth is the file's.
  void walk_nodes() {
    std::vector<bool> is_seen(document_.nodes.size(), false);
    std::vector<Visit> stack;
    const auto push = [&](const std::vector<int>& nodes, const Eigen::Matrix4d& scene_from_parent) {
      for (auto node = nodes.rbegin(); node != nodes.rend(); ++node)
        stack.push_back({*node, scene_from_parent});
    };
    push(document_.roots, Eigen::Matrix4d::Identity());
    while (!stack.empty()) {
      const Visit visit = stack.back();
      stack.pop_back();
      const auto node_idx = static_cast<std::size_t>(visit.node_idx);
      if (is_seen[node_idx])
        throw FormatError("node " + std::to_string(node_idx) + " stands twice in the scene (glTF header)",
                          kHintDamaged);
      is_seen[node_idx] = true;
      const GltfNode& node = document_.nodes[node_idx];
      const Eigen::Matrix4d scene_from_node = visit.scene_from_parent * node.parent_from_node;
      if (node.mesh_idx >= 0)
        add_mesh(document_.meshes[static_cast<std::size_t>(node.mesh_idx)], Placement(scene_from_node));
      push(node.children, scene_from_node);
    }
  }

  /// Primitives of one mesh often share their vertices: these are taken once.
  void add_mesh(const std::vector<GltfPrimitive>& primitives, const Placement& placement) {
    std::map<std::array<int, 3>, std::size_t> first_points;
    for (const GltfPrimitive& primitive : primitives) {
      if (primitive.draco) {
        add_draco(primitive, placement);
        continue;
      }
      if (primitive.position_idx < 0) continue;
      const auto [entry, is_new] = first_points.try_emplace(
          {primitive.position_idx, primitive.normal_idx, primitive.colour_idx}, builder_.size());
      if (is_new) add_points(primitive, placement);
      add_triangles(primitive, placement, entry->second);
    }
  }

  void announce_points(std::uint64_t more) {
    CloudBuilder::check_count(builder_.size() + more, limits_, "accessors");
    check_points_per_byte(builder_.size() + more, file_bytes_, 0);
    if (builder_.size() == 0) builder_.reserve(more);
  }

  void announce_triangles(std::uint64_t more) {
    auto& triangles = builder_.scan.triangles;
    check_points_per_byte((triangles.size() + more) / 2, file_bytes_, 0);
    if (triangles.empty()) triangles.reserve(more);
  }

  void add_position(const Eigen::Vector3d& p, const Placement& placement) {
    const Eigen::Vector4d placed = placement.scene_from_node * p.homogeneous();
    builder_.add_position(placed.x(), placed.y(), placed.z());
  }

  void add_normal(const Eigen::Vector3d& n, const Placement& placement) {
    const Eigen::Vector3d placed = placement.normals * n;
    builder_.add_normal(placed.x(), placed.y(), placed.z());
  }

  void add_colour(const Eigen::Vector3d& c) {
    builder_.add_colour_bytes(to_srgb_byte(c.x()), to_srgb_byte(c.y()), to_srgb_byte(c.z()));
  }

  void add_points(const GltfPrimitive& primitive, const Placement& placement) {
    const GltfNumbers positions(document_, primitive.position_idx, 3);
    announce_points(positions.size());
    for (std::uint64_t i = 0; i < positions.size(); ++i) add_position(positions.row(i), placement);
    if (primitive.normal_idx >= 0) {
      const GltfNumbers normals(document_, primitive.normal_idx, 3);
      check_same_size(normals.size(), positions.size(), "NORMAL");
      for (std::uint64_t i = 0; i < normals.size(); ++i) add_normal(normals.row(i), placement);
    }
    if (primitive.colour_idx >= 0) {
      const GltfNumbers colours(document_, primitive.colour_idx, 3);
      check_same_size(colours.size(), positions.size(), "COLOR_0");
      for (std::uint64_t i = 0; i < colours.size(); ++i) add_colour(colours.row(i));
    }
  }

  static void check_same_size(std::uint64_t rows, std::uint64_t points, const char* name) {
    if (rows != points)
      throw FormatError(std::string(name) + " has " + std::to_string(rows) + " rows, POSITION " +
                            std::to_string(points) + " (glTF header)",
                        kHintDamaged);
  }

  void add_triangles(const GltfPrimitive& primitive, const Placement& placement, std::size_t first) {
    if (primitive.mode < kTriangles || primitive.mode > kTriangleFan) return;
    const std::size_t points = GltfNumbers(document_, primitive.position_idx, 3).size();
    if (primitive.indices_idx < 0) {
      announce_triangles(points / (primitive.mode == kTriangles ? 3 : 1));
      add_corners(primitive.mode, points, placement,
                  [&](std::uint64_t i) { return static_cast<int>(first + i); });
      return;
    }
    const GltfNumbers indices(document_, primitive.indices_idx, 1);
    announce_triangles(indices.size() / (primitive.mode == kTriangles ? 3 : 1));
    for (std::uint64_t i = 0; i < indices.size(); ++i)
      if (!(indices.at(i, 0) >= 0.0 && indices.at(i, 0) < static_cast<double>(points)))
        throw FormatError("a triangle names a vertex beyond the " + std::to_string(points) +
                              " there are (accessor " + std::to_string(primitive.indices_idx) + ")",
                          kHintDamaged);
    add_corners(primitive.mode, indices.size(), placement, [&](std::uint64_t i) {
      return static_cast<int>(first) + static_cast<int>(indices.at(i, 0));
    });
  }

  template <typename Corner>
  void add_corners(int mode, std::uint64_t count, const Placement& placement, const Corner& corner) {
    if (mode == kTriangles) {
      for (std::uint64_t i = 0; i + 3 <= count; i += 3)
        add_triangle({corner(i), corner(i + 1), corner(i + 2)}, placement);
    } else {
      for (std::uint64_t i = 2; i < count; ++i) {
        const bool is_strip = mode == kTriangleStrip, is_odd = i % 2 == 1;
        const int a = is_strip ? corner(i - 2) : corner(0);
        add_triangle(is_strip && is_odd ? Eigen::Vector3i(corner(i - 1), a, corner(i))
                                        : Eigen::Vector3i(a, corner(i - 1), corner(i)),
                     placement);
      }
    }
  }

  void add_triangle(Eigen::Vector3i triangle, const Placement& placement) {
    if (placement.is_mirrored) std::swap(triangle[1], triangle[2]);
    builder_.scan.triangles.push_back(triangle);
  }

  void add_draco(const GltfPrimitive& primitive, const Placement& placement) {
    const std::span<const std::byte> stream = bytes_of_view(document_, primitive.draco->view_idx);
    const auto file_byte =
        document_.binary_byte + static_cast<std::size_t>(stream.data() - document_.binary.data());
    DracoAttributeIds ids = primitive.draco->ids;
    const bool has_normals = ids.normal >= 0, has_colours = ids.colour >= 0;
    const DracoGeometry geometry(stream, file_byte, ids, limits_);
    const std::size_t first = builder_.size(), points = geometry.point_count();
    announce_points(points);
    for (std::size_t i = 0; i < points; ++i) {
      add_position(geometry.position(i), placement);
      if (has_normals && geometry.has_normals()) add_normal(geometry.normal(i), placement);
      if (has_colours && geometry.has_colours()) add_colour(geometry.colour(i));
    }
    announce_triangles(geometry.triangle_count());
    for (std::size_t i = 0; i < geometry.triangle_count(); ++i)
      add_triangle(geometry.triangle(i).array() + static_cast<int>(first), placement);
  }

  GltfDocument document_;
  const ScanLimits& limits_;
  std::size_t file_bytes_;
  CloudBuilder builder_;
};

}  // namespace

ScanFile read_glb(std::span<const std::byte> bytes, const ScanLimits& limits) {
  return GlbReader(bytes, limits).read();
}

}  // namespace phiz::readers
