#include "tests/bench/correspondence.h"

#include <Eigen/LU>
#include <limits>

#include "stages/geometry/surface_index.h"

namespace phiz::bench {
namespace {

struct Mean {
  double sum = 0;
  std::size_t count = 0;
  void add(double value) {
    sum += value;
    ++count;
  }
  double value() const {
    return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
  }
};

/// Where every vertex of a subject lies on its true skin.
std::vector<SurfaceHit> find_true_places(const Placed& subject, const TruthLabels& labels) {
  const std::span<const Eigen::Vector3i> skin(subject.truth.triangles.data(),
                                              static_cast<std::size_t>(labels.skin_triangles));
  return SurfaceIndex(subject.truth.positions, skin)
      .find_nearest(to_float(subject.vertices), std::numeric_limits<double>::infinity());
}

Eigen::Vector3d place_at(const TriangleMesh& mesh, const SurfaceHit& hit) {
  const Eigen::Vector3i& triangle = mesh.triangles[hit.triangle_idx];
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (int corner = 0; corner < 3; ++corner) {
    place += hit.weights[corner] * mesh.positions[triangle[corner]].cast<double>();
  }
  return place;
}

/// Vertices that touch the mouth pocket or the nostrils, which no scanner sees.
std::vector<bool> find_hidden(const GenericHead& head) {
  std::vector<bool> hidden(head.mesh.positions.size(), false);
  for (const char* region : {"inner_mouth", "nostrils"}) {
    for (const int vertex : head.mesh.annotations.regions.at(region)) hidden[vertex] = true;
  }
  for (int level = 1; level <= kCorrespondenceLevel; ++level) {
    const int old_count = head.hierarchy.vertex_count(level - 1);
    hidden.resize(head.hierarchy.vertex_count(level));
    for (int vertex = old_count; vertex < head.hierarchy.vertex_count(level); ++vertex) {
      const Eigen::Vector2i parents = head.hierarchy.parents(level, vertex);
      hidden[vertex] = hidden[parents[0]] || hidden[parents[1]];
    }
  }
  return hidden;
}

/// A landmark as a point of the surface of kCorrespondenceLevel: found by its (u,v) among the children of its
/// triangle.
SurfacePoint refine(const SurfacePoint& point, const GenericHead& head,
                    const std::vector<Eigen::Vector2d>& fine_uv) {
  Eigen::Vector2d uv = Eigen::Vector2d::Zero();
  for (int corner = 0; corner < 3; ++corner) {
    uv += point.weights[corner] * head.mesh.uv[head.mesh.triangles[point.triangle_idx][corner]];
  }
  const int children = 1 << (2 * kCorrespondenceLevel);
  SurfacePoint best;
  double best_least = -std::numeric_limits<double>::infinity();
  for (int child = children * point.triangle_idx; child < children * (point.triangle_idx + 1); ++child) {
    const Eigen::Vector3i& triangle = head.hierarchy.triangles(kCorrespondenceLevel)[child];
    Eigen::Matrix3d corners;
    for (int corner = 0; corner < 3; ++corner) corners.col(corner) << fine_uv[triangle[corner]], 1.0;
    const Eigen::Vector3d weights = corners.inverse() * Eigen::Vector3d(uv.x(), uv.y(), 1.0);
    if (weights.minCoeff() <= best_least) continue;
    best_least = weights.minCoeff();
    best = {child, weights};
  }
  return best;
}

}  // namespace

Correspondence measure_correspondence(const std::vector<Placed>& subjects, const GenericHead& head,
                                      const TruthLabels& labels) {
  const std::vector<bool> hidden = find_hidden(head);
  std::map<std::string, std::vector<bool>> inside;
  for (const char* region : {"ears", "lips", "eyelids", "nose"}) {
    inside[region] = head.region_at(region, kCorrespondenceLevel);
  }
  Mean narrow, narrow_all;
  std::map<std::string, Mean> regions;
  Correspondence result;
  for (const Placed& a : subjects) {
    const std::vector<SurfaceHit> places = find_true_places(a, labels);
    for (const Placed& b : subjects) {
      if (&a == &b || a.truth.triangles != b.truth.triangles) continue;
      ++result.pairs;
      for (std::size_t vertex = 0; vertex < places.size(); ++vertex) {
        const double error = (place_at(b.truth, places[vertex]) - b.vertices[vertex]).norm();
        const bool is_narrow =
            a.truth.triangles[places[vertex].triangle_idx].maxCoeff() <= labels.narrow_face_last;
        if (is_narrow) narrow_all.add(error);
        if (hidden[vertex]) continue;
        if (is_narrow) narrow.add(error);
        for (const auto& [region, vertices] : inside) {
          if (vertices[vertex]) regions[region].add(error);
        }
      }
    }
  }
  result.narrow_face = narrow.value();
  result.narrow_face_all = narrow_all.value();
  for (const auto& [region, error] : regions) result.regions[region] = error.value();
  return result;
}

std::map<std::string, double> measure_landmarks(const std::vector<Placed>& subjects, const GenericHead& head,
                                                const TruthLabels& labels) {
  std::map<std::string, double> means;
  const std::vector<Eigen::Vector2d> uv = evaluate_uv(head.hierarchy, head.mesh.uv, kCorrespondenceLevel);
  for (const auto& [name, point] : head.mesh.annotations.landmarks) {
    const auto truth = labels.landmarks.find(name);
    if (truth == labels.landmarks.end() || name.find("ear_") != std::string::npos ||
        name.find("tragus") != std::string::npos) {
      continue;
    }
    const SurfacePoint fine = refine(point, head, uv);
    Mean error;
    for (const Placed& subject : subjects) {
      const Eigen::Vector3d place =
          position_at(fine, head.hierarchy.triangles(kCorrespondenceLevel), subject.vertices);
      error.add((place - subject.truth.positions[truth->second].cast<double>()).norm());
    }
    means[name] = error.value();
  }
  return means;
}

}  // namespace phiz::bench
