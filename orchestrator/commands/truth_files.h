#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "formats/triangle_mesh.h"
#include "orchestrator/session.h"
#include "stages/evaluate/evaluate.h"

namespace phiz {

/// A truth mesh. Throws FormatError, also for a mesh without triangles.
TriangleMesh read_truth_mesh(const std::filesystem::path& path);

/// What a file says of one subject's truth.
struct TruthPose {
  Eigen::Matrix4d truth_from_scan = Eigen::Matrix4d::Identity();
  std::map<std::string, Eigen::Vector3d> landmarks_mm;  ///< in the truth's frame; may be empty
};

/// `text` is a 4x4 truth_from_scan ("[[1,0,0,0],...]"), or a JSON file with one, with a subject's
/// `scan_from_truth`, or a subjects.json. Throws UsageError, FormatError.
TruthPose read_truth_pose(const std::string& text, const std::string& subject, const Session& session);

/// `regions`: name -> [first, last] vertex, as in a vertex_labels.json. Throws FormatError.
Regions read_truth_regions(const std::filesystem::path& path, std::size_t vertex_count,
                           const Session& session);

/// `landmarks`: list of {name, vertex}. Throws FormatError.
std::map<std::string, Eigen::Vector3d> read_truth_landmarks(const std::filesystem::path& path,
                                                            const TriangleMesh& truth,
                                                            const Session& session);

}  // namespace phiz
