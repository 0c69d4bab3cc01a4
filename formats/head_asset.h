#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "formats/triangle_mesh.h"

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
  /// V(k-1) repeat the coarser level's and are not stored. May be empty.
  std::vector<std::vector<std::uint8_t>> confidences;
  Eigen::Matrix4d scan_from_head =
      Eigen::Matrix4d::Identity();  ///< head mm -> the scan's own frame and units
  double tolerance_mm = 0;  ///< how far its surface lies from what it was made of, at most; 0: not stated
  std::map<std::string, std::string> provenance;  ///< name -> digest of what it was made of
};

struct HeadAssetOptions {
  double displacement_step_mm = 0.02;  ///< quantisation step, in [1e-5, 10]: error is at most half of it
  double position_step_mm = 0.01;      ///< of the control vertices, in [1e-4, 10]; at most 2^22 steps across
  int texture_steps = 65535;           ///< (u,v) are whole shares of it, in [255, 65535]
  int confidence_step = 1;             ///< confidences are multiples of it, in [1, 255]
  /// What viewers that do not know the extension show, in mm; null: the control mesh, which costs nothing.
  const TriangleMesh* shown = nullptr;
  int shown_level = 0;          ///< which level it is, for readers to know
  double shown_step_mm = 0.25;  ///< quantisation of its positions
};

/// One valid .glb, schema 2 of PHIZ_displaced_subdivision (HEAD_ASSET.md is the specification): a Draco
/// primitive any viewer shows and an extension with the control mesh and a stream of displacements a level,
/// in an order in which any prefix gives a coarser head. Every stream is decoded again and compared. Keeps
/// order; same content, same bytes, also when it was read from such a file (with the same options). Throws
/// FormatError: sizes that do not belong together, triangles that are no surface, numbers that are not finite
/// or out of range. Level 4 (400,000 vertices) takes 0.1 s, 0.3 s with confidences.
void write_head_asset(const HeadAsset& head, const HeadAssetOptions& options, std::ostream& out);

/// Reads what write_head_asset wrote, now or in any earlier version; a damaged file is refused, every count
/// and index is checked before use. Throws FormatError. Level 4 takes 0.04 s.
HeadAsset read_head_asset(std::istream& in);

/// The head as far as the first bytes of a file tell: as many levels as they hold whole, none where only the
/// control mesh is there, and without (u,v) where these are cut off. Each stream is checked by its own sum.
/// Throws FormatError where there is not even a control mesh, and for files of schema 1.
HeadAsset read_head_asset_prefix(std::string_view bytes);

/// A stream of a head asset's file, for people: what it holds and how long it is.
struct HeadAssetPart {
  std::string name;
  std::size_t end = 0;  ///< of the file's bytes that are needed up to this part, all included
  std::size_t bytes = 0;
};
/// "document", "control mesh", "texture coordinates", "level 0" ... in the order of the file. Throws
/// FormatError.
std::vector<HeadAssetPart> list_head_asset_parts(std::string_view bytes);

}  // namespace phiz
