#include "stages/template/canonical_order.h"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>

#include <algorithm>
#include <array>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

/// What came back: old index of each new vertex, and the triangles in new indices.
struct Returned {
  std::vector<int> old_vertex;
  std::vector<Eigen::Vector3i> triangles;
};

Returned send_through_codec(const std::vector<Eigen::Vector3i>& triangles, std::size_t vertex_count,
                            int speed) {
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(vertex_count));
  mesh.SetNumFaces(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Eigen::Vector3i& corners = triangles[triangles.size() - 1 - t];  // last first: see the header
    draco::Mesh::Face face;
    for (int k = 0; k < 3; ++k) face[k] = draco::PointIndex(static_cast<std::uint32_t>(corners[(k + 2) % 3]));
    mesh.SetFace(draco::FaceIndex(static_cast<std::uint32_t>(t)), face);
  }
  // Positions that are all different, so that the codec merges none, and that carry the vertex's number
  // exactly.
  draco::GeometryAttribute attribute;
  attribute.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_INT32, false, 12, 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(vertex_count));
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const std::array<std::int32_t, 3> row = {static_cast<std::int32_t>(v), 0, 0};
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(v)),
                                          row.data());
  }
  draco::ExpertEncoder encoder(mesh);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(speed, speed);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) throw NumericalFailure("Draco cannot encode the mesh");

  draco::DecoderBuffer input;
  input.Init(buffer.data(), buffer.size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&input);
  if (!decoded.ok()) throw NumericalFailure("Draco cannot decode the mesh");
  const draco::Mesh& result = *decoded.value();
  if (result.num_points() != vertex_count || result.num_faces() != triangles.size()) {
    throw NumericalFailure("Draco drops or splits vertices of the mesh");
  }
  Returned returned;
  const auto* column = result.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  for (std::uint32_t v = 0; v < result.num_points(); ++v) {
    std::array<std::int32_t, 3> row{};
    column->GetMappedValue(draco::PointIndex(v), row.data());
    returned.old_vertex.push_back(row[0]);
  }
  for (std::uint32_t t = 0; t < result.num_faces(); ++t) {
    const auto& face = result.face(draco::FaceIndex(t));
    returned.triangles.push_back({static_cast<int>(face[0].value()), static_cast<int>(face[1].value()),
                                  static_cast<int>(face[2].value())});
  }
  return returned;
}

/// Old triangle and rotation of each new triangle.
void follow_landmarks(ControlMesh& mesh, const std::vector<Eigen::Vector3i>& old_in_new_indices) {
  std::map<std::array<int, 3>, int> found;
  const auto key = [](const Eigen::Vector3i& t) {
    std::array<int, 3> k = {t[0], t[1], t[2]};
    std::sort(k.begin(), k.end());
    return k;
  };
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) found[key(mesh.triangles[t])] = t;
  for (auto& [name, point] : mesh.annotations.landmarks) {
    const Eigen::Vector3i old = old_in_new_indices[point.triangle_idx];
    SurfacePoint moved{found.at(key(old)), Eigen::Vector3d::Zero()};
    for (int k = 0; k < 3; ++k) {
      for (int j = 0; j < 3; ++j) {
        if (mesh.triangles[moved.triangle_idx][k] == old[j]) moved.weights[k] = point.weights[j];
      }
    }
    point = moved;
  }
}

void apply(ControlMesh& mesh, const Returned& order) {
  const std::size_t n = order.old_vertex.size();
  std::vector<int> renamed(n);
  ControlMesh old = mesh;
  for (std::size_t v = 0; v < n; ++v) {
    renamed[order.old_vertex[v]] = static_cast<int>(v);
    mesh.positions[v] = old.positions[order.old_vertex[v]];
    mesh.uv[v] = old.uv[order.old_vertex[v]];
  }
  std::vector<Eigen::Vector3i> old_triangles;
  for (const auto& t : old.triangles) old_triangles.push_back({renamed[t[0]], renamed[t[1]], renamed[t[2]]});
  mesh.triangles = order.triangles;
  auto& notes = mesh.annotations;
  const auto rename = [&](std::vector<int>& vertices) {
    for (int& v : vertices) v = renamed[v];
    std::sort(vertices.begin(), vertices.end());
  };
  for (auto& [name, vertices] : notes.regions) rename(vertices);
  rename(notes.constrained_vertices);
  for (auto& edge : notes.binding_edges) edge = std::minmax(renamed[edge.first], renamed[edge.second]);
  std::sort(notes.binding_edges.begin(), notes.binding_edges.end());
  for (std::size_t v = 0; v < notes.mirror.size(); ++v) {
    notes.mirror[renamed[v]] = renamed[old.annotations.mirror[v]];
  }
  follow_landmarks(mesh, old_triangles);
}

constexpr int kSpeeds[] = {0, 5, 7, 10};

bool is_fixed_point(const ControlMesh& mesh, int speed) {
  const Returned returned = send_through_codec(mesh.triangles, mesh.positions.size(), speed);
  for (std::size_t v = 0; v < returned.old_vertex.size(); ++v) {
    if (returned.old_vertex[v] != static_cast<int>(v)) return false;
  }
  return returned.triangles == mesh.triangles;
}

}  // namespace

bool canonicalise_order(ControlMesh& mesh) {
  constexpr int kMaxRounds = 100;
  for (int round = 0; round < kMaxRounds; ++round) {
    apply(mesh, send_through_codec(mesh.triangles, mesh.positions.size(), kSpeeds[0]));
    if (is_canonical_order(mesh)) return true;
  }
  return false;
}

bool is_canonical_order(const ControlMesh& mesh) {
  return std::all_of(std::begin(kSpeeds), std::end(kSpeeds),
                     [&](int speed) { return is_fixed_point(mesh, speed); });
}

}  // namespace phiz
