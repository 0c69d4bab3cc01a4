#include "orchestrator/commands/truth_files.h"

#include <Eigen/LU>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/scan_file.h"
#include "orchestrator/error.h"
#include "orchestrator/tasks/nouns.h"
#include "store/error.h"

namespace phiz {
namespace {

using nlohmann::ordered_json;

constexpr std::uint64_t kMaxJsonBytes = 256 << 20;

ordered_json read_json(const std::filesystem::path& path, const Session& session) {
  ordered_json object;
  with_place(path.string(), [&] {
    try {
      object = ordered_json::parse(session.files().read_file(path, kMaxJsonBytes));
    } catch (const StoreError& error) {
      throw FormatError(error.what(), error.hint());
    }
  });
  return object;
}

Eigen::Matrix4d read_matrix(const ordered_json& rows) {
  Eigen::Matrix4d matrix;
  try {
    matrix = matrix_from_json(rows);
  } catch (const nlohmann::json::exception&) {
    throw FormatError("a pose has four rows of four numbers");
  }
  const double volume = matrix.topLeftCorner<3, 3>().determinant();
  if (!matrix.allFinite() || !(volume > 0) || matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    throw FormatError("the pose is no rotation, scale and shift");
  }
  return matrix;
}

/// Of an object with `scan_from_truth`.
TruthPose read_record(const ordered_json& record) {
  TruthPose pose;
  pose.truth_from_scan = read_matrix(record.at("scan_from_truth")).inverse();
  if (!record.contains("landmarks_mm")) return pose;
  for (const auto& [name, point] : record.at("landmarks_mm").items()) {
    for (int i = 0; i < 3; ++i) pose.landmarks_mm[name][i] = point.at(i).get<double>();
  }
  return pose;
}

TruthPose read_pose_object(const ordered_json& object, const std::string& subject) {
  if (object.is_array()) return {read_matrix(object), {}};
  if (!object.contains("subjects")) return read_record(object);
  if (!object.at("subjects").contains(subject)) throw FormatError("no subject '" + subject + "' in it");
  return read_record(object.at("subjects").at(subject));
}

}  // namespace

TriangleMesh read_truth_mesh(const std::filesystem::path& path) {
  ScanFile file = read_scan_file(path);
  if (file.triangles.empty()) throw FormatError(path.string() + ": the truth has no triangles");
  TriangleMesh mesh;
  mesh.triangles = std::move(file.triangles);
  for (const Eigen::Vector3f& position : file.points.positions) {
    mesh.positions.push_back((file.origin + position.cast<double>()).cast<float>());
  }
  with_place(path.string(), [&] { check_mesh(mesh); });
  return mesh;
}

TruthPose read_truth_pose(const std::string& text, const std::string& subject, const Session& session) {
  TruthPose pose;
  if (text.starts_with('[')) {
    try {
      pose = read_pose_object(ordered_json::parse(text), subject);
    } catch (const nlohmann::json::exception&) {
      throw UsageError("--truth-from-scan is no JSON");
    } catch (const FormatError& error) {
      throw UsageError(std::string("--truth-from-scan: ") + error.what());
    }
    return pose;
  }
  const ordered_json object = read_json(text, session);
  with_place(text, [&] { pose = read_pose_object(object, subject); });
  return pose;
}

Regions read_truth_regions(const std::filesystem::path& path, std::size_t vertex_count,
                           const Session& session) {
  const ordered_json object = read_json(path, session);
  Regions regions;
  with_place(path.string(), [&] {
    for (const auto& [name, range] : object.at("regions").items()) {
      const auto first = range.at(0).get<std::size_t>(), last = range.at(1).get<std::size_t>();
      if (first > last || last >= vertex_count)
        throw FormatError("region '" + name + "' is not in the truth");
      std::vector<bool>& flags = regions[name];
      flags.assign(vertex_count, false);
      std::fill(flags.begin() + static_cast<std::ptrdiff_t>(first),
                flags.begin() + static_cast<std::ptrdiff_t>(last) + 1, true);
    }
  });
  return regions;
}

std::map<std::string, Eigen::Vector3d> read_truth_landmarks(const std::filesystem::path& path,
                                                            const TriangleMesh& truth,
                                                            const Session& session) {
  const ordered_json object = read_json(path, session);
  std::map<std::string, Eigen::Vector3d> landmarks;
  with_place(path.string(), [&] {
    for (const ordered_json& landmark : object.at("landmarks")) {
      const auto vertex_idx = landmark.at("vertex").get<std::size_t>();
      const auto name = landmark.at("name").get<std::string>();
      if (vertex_idx >= truth.positions.size()) {
        throw FormatError("landmark '" + name + "' is not in the truth");
      }
      landmarks[name] = truth.positions[vertex_idx].cast<double>();
    }
  });
  return landmarks;
}

}  // namespace phiz
