#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "formats/control_mesh.h"
#include "formats/point_cloud.h"
#include "stages/subdivide/subdivide.h"
#include "tests/bench/phiz_runs.h"

namespace phiz::bench {

using Positions = std::vector<Eigen::Vector3d>;

/// The generic head with its hierarchy: what all subjects share.
struct GenericHead {
  ControlMesh mesh;
  SubdivisionHierarchy hierarchy;

  /// 1 where a vertex of `level` lies inside the region: all control vertices it was born of do.
  std::vector<bool> region_at(const std::string& region, int level) const;
};

/// `obj` with its .json beside it.
GenericHead load_generic_head(const std::filesystem::path& obj, int levels);

/// A fitted subject as the store holds it. Everything is in the head frame, mm.
struct FittedHead {
  PointCloud cloud;  ///< what ingest kept
  Positions aligned, local, control;
  std::vector<std::vector<float>> displacements_mm;
  Eigen::Matrix4d scan_from_head = Eigen::Matrix4d::Identity();
  double head_scale = 1;  ///< size over the generic head's
};

FittedHead load_fitted(const std::filesystem::path& store, const SubjectRun& run, const GenericHead& head);

/// The finished surface at the hierarchy's finest level.
Positions evaluate_finest(const FittedHead& fitted, const GenericHead& head);

Positions transform(const Eigen::Matrix4d& to_from, const Positions& positions);
Positions transform(const Eigen::Matrix4d& to_from, std::span<const Eigen::Vector3f> positions);
std::vector<Eigen::Vector3f> to_float(const Positions& positions);

}  // namespace phiz::bench
