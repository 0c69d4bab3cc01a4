#include "tests/bench/fitted.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "formats/head_asset.h"

namespace phiz::bench {
namespace {

using nlohmann::json;

std::string read_output(const std::filesystem::path& store, const SubjectRun& run, const std::string& stage,
                        const std::string& output) {
  const std::map<std::string, std::string> digests = run.digests();
  const auto digest = digests.find(stage + "/" + output);
  if (digest == digests.end()) throw std::runtime_error("no output " + stage + "/" + output);
  return read_object(store, digest->second);
}

Eigen::Matrix4d to_matrix(const json& rows) {
  Eigen::Matrix4d matrix;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) matrix(row, column) = rows.at(row).at(column).get<double>();
  }
  return matrix;
}

/// The `v` lines of an OBJ.
Positions parse_obj_positions(const std::string& text) {
  Positions positions;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("v ")) continue;
    std::istringstream words(line.substr(2));
    Eigen::Vector3d position;
    words >> position.x() >> position.y() >> position.z();
    positions.push_back(position);
  }
  return positions;
}

}  // namespace

std::vector<bool> GenericHead::region_at(const std::string& region, int level) const {
  std::vector<bool> inside(mesh.positions.size(), false);
  const auto found = mesh.annotations.regions.find(region);
  if (found == mesh.annotations.regions.end())
    throw std::runtime_error("the generic head has no region " + region);
  for (const int vertex : found->second) inside[vertex] = true;
  for (int fine = 1; fine <= level; ++fine) {
    const int old_count = hierarchy.vertex_count(fine - 1);
    inside.resize(hierarchy.vertex_count(fine));
    for (int vertex = old_count; vertex < hierarchy.vertex_count(fine); ++vertex) {
      const Eigen::Vector2i parents = hierarchy.parents(fine, vertex);
      inside[vertex] = inside[parents[0]] && inside[parents[1]];
    }
  }
  return inside;
}

GenericHead load_generic_head(const std::filesystem::path& obj_path, int levels) {
  std::ifstream obj(obj_path), annotations(std::filesystem::path(obj_path).replace_extension(".json"));
  ControlMesh mesh = read_control_mesh(obj, annotations);
  SubdivisionHierarchy hierarchy(mesh.triangles, static_cast<int>(mesh.positions.size()), levels);
  return {std::move(mesh), std::move(hierarchy)};
}

FittedHead load_fitted(const std::filesystem::path& store, const SubjectRun& run, const GenericHead& head) {
  FittedHead fitted;
  std::istringstream cloud(read_output(store, run, "ingest", "cloud.vdb"));
  fitted.cloud = read_vdb_points(cloud);
  fitted.head_scale =
      json::parse(read_output(store, run, "ingest", "ingest.json")).at("head_scale").get<double>();
  const json alignment = json::parse(read_output(store, run, "align", "alignment.json"));
  fitted.aligned = transform(to_matrix(alignment.at("head_from_model")), head.mesh.positions);
  fitted.local = parse_obj_positions(read_output(store, run, "fit_local", "local.obj"));
  fitted.control = parse_obj_positions(read_output(store, run, "fit_global", "control.obj"));
  std::istringstream asset_bytes(read_output(store, run, "subdivide", "head.glb"));
  HeadAsset asset = read_head_asset(asset_bytes);
  for (std::size_t i = 0; i < asset.positions.size(); ++i)
    fitted.control[i] = asset.positions[i].cast<double>();
  fitted.displacements_mm = std::move(asset.displacements_mm);
  fitted.scan_from_head = asset.scan_from_head;
  return fitted;
}

Positions evaluate_finest(const FittedHead& fitted, const GenericHead& head) {
  return evaluate_surface(head.hierarchy, fitted.control, fitted.displacements_mm,
                          head.hierarchy.level_count());
}

Positions transform(const Eigen::Matrix4d& to_from, const Positions& positions) {
  Positions result;
  result.reserve(positions.size());
  for (const Eigen::Vector3d& p : positions) {
    result.push_back(to_from.topLeftCorner<3, 3>() * p + to_from.topRightCorner<3, 1>());
  }
  return result;
}

Positions transform(const Eigen::Matrix4d& to_from, std::span<const Eigen::Vector3f> positions) {
  Positions result;
  result.reserve(positions.size());
  for (const Eigen::Vector3f& p : positions) {
    result.push_back(to_from.topLeftCorner<3, 3>() * p.cast<double>() + to_from.topRightCorner<3, 1>());
  }
  return result;
}

std::vector<Eigen::Vector3f> to_float(const Positions& positions) {
  std::vector<Eigen::Vector3f> result;
  result.reserve(positions.size());
  for (const Eigen::Vector3d& position : positions) result.push_back(position.cast<float>());
  return result;
}

}  // namespace phiz::bench
