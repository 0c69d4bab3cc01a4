#include "stages/deform/deform.h"
#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

constexpr int kFinestLevel = 6;

int checked(int level) {
  if (level < 0 || level > kFinestLevel) throw InvalidInput("level is not from 0 to 6");
  return level;
}

/// Quaternions of all vertices of `level`, linear in the control triangles.
std::vector<Eigen::Vector4d> refine_frames(const SubdivisionHierarchy& hierarchy,
                                           const std::vector<Eigen::Quaterniond>& control, int level) {
  std::vector<Eigen::Vector4d> frames;
  frames.reserve(hierarchy.vertex_count(level));
  for (const Eigen::Quaterniond& frame : control) frames.push_back(frame.coeffs());
  for (int k = 1; k <= level; ++k) {
    for (int v = hierarchy.vertex_count(k - 1); v < hierarchy.vertex_count(k); ++v) {
      const Eigen::Vector2i ends = hierarchy.parents(k, v);
      frames.push_back(0.5 * (frames[ends[0]] + frames[ends[1]]));
    }
  }
  return frames;
}

}  // namespace

NeutralMaker::NeutralMaker(const ControlMesh& generic_head, int level)
    : level_(checked(level)),
      annotations_(generic_head.annotations),
      hierarchy_(generic_head.triangles, static_cast<int>(generic_head.positions.size()), level),
      frames_(generic_head),
      uv_(evaluate_uv(hierarchy_, generic_head.uv, level)) {}

NeutralSurface NeutralMaker::make(std::span<const Eigen::Vector3d> control_positions,
                                  std::span<const std::vector<float>> displacements_mm) const {
  if (static_cast<int>(control_positions.size()) != hierarchy_.vertex_count(0))
    throw InvalidInput("the subject's control mesh is not the generic head's");
  NeutralSurface neutral;
  neutral.uv = uv_;
  for (const Eigen::Vector3d& p : evaluate_surface(hierarchy_, control_positions, displacements_mm, level_))
    neutral.positions.push_back(p.cast<float>());
  const std::vector<Eigen::Vector4d> frames =
      refine_frames(hierarchy_, frames_.compute(control_positions), level_);
  neutral.frames.resize(frames.size());
  parallel_for(frames.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Eigen::Quaterniond frame;
      frame.coeffs() = frames[i].normalized();
      neutral.frames[i] = frame.toRotationMatrix().cast<float>();
    }
  });
  const std::vector<Eigen::Vector3d> control(control_positions.begin(), control_positions.end());
  for (const auto& [name, point] : annotations_.landmarks)
    neutral.landmarks[name] = position_at(point, hierarchy_.triangles(0), control);
  return neutral;
}

}  // namespace phiz
