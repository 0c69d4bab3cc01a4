#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace phiz {

/// A fitted head: the generic head's control mesh in the shape of one subject, and one scalar displacement
/// per vertex and level along the normal of the subdivided surface (Modified Butterfly, `stages/subdivide`).
/// Vertex k is the same anatomical place in every subject at every level. Level k+1 splits each triangle of
/// level k in four: its vertices are those of level k and then one for each edge of level k.
struct HeadAsset {
  std::string template_digest;             ///< SHA-256 of the generic head it was fitted with; may be empty
  std::vector<Eigen::Vector3f> positions;  ///< control vertices, mm, head frame
  std::vector<Eigen::Vector3i> triangles;  ///< of the generic head, order kept
  std::vector<Eigen::Vector2f> uv;         ///< of the generic head, in [0,1], v upwards
  /// displacements_mm[k] has one entry per vertex of level k: the first V(k-1) belong to the vertices of the
  /// coarser level and are zero (level k+1 interpolates level k); they are not stored. Level 0 has all V(0).
  std::vector<std::vector<float>> displacements_mm;
  /// confidences[k], same sizes: 1 measured, 0.5 bridged, 0 invented; one byte each, 255 = 1. The first
  /// V(k-1) repeat the coarser level's and are not stored.
  std::vector<std::vector<std::uint8_t>> confidences;
  Eigen::Matrix4d scan_from_head =
      Eigen::Matrix4d::Identity();  ///< head mm -> the scan's own frame and units
};

struct HeadAssetOptions {
  double displacement_step_mm = 0.02;  ///< quantisation step, in [1e-5, 10]: error is at most half of it
  double position_step_mm = 0.01;      ///< of the control vertices, in [1e-4, 10]; at most 2^22 steps across
};

/// One valid .glb (README.md documents every field): a Draco primitive any viewer shows (level 0 until
/// `publish` bakes a finer one) and the extension PHIZ_displaced_subdivision with the displacement streams.
/// Keeps order; same content, same bytes, also when it was read from such a file (with the same options).
/// (u,v) have 16 bits. Throws FormatError: sizes that do not belong together, numbers that are not finite or
/// out of range. Level 4 (350,000 vertices) takes 0.1 s.
void write_head_asset(const HeadAsset& head, const HeadAssetOptions& options, std::ostream& out);

/// Reads what write_head_asset wrote; a damaged file is refused, every count and index is checked before use.
/// Throws FormatError. Level 4 takes 0.05 s.
HeadAsset read_head_asset(std::istream& in);

}  // namespace phiz
