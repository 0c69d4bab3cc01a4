#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"
#include "stages/adapt/adapt.h"
#include "stages/geometry/surface_index.h"
#include "tests/bench/areas.h"

namespace phiz::bench {

/// A fitted subject's level 4 over (u,v), ready to be adapted to, and an index of it to measure with.
struct AdaptSubject {
  std::string name;
  std::vector<Eigen::Vector3d> control;
  std::vector<std::vector<float>> displacements_mm;
  std::vector<Eigen::Vector3f> positions, normals;
  SurfacePoints points;
  MadeBase face_base;           ///< of the authored 113 points
  std::vector<int> base_faces;  ///< of the points
};

struct AdaptWorld {
  const BenchWorld& bench;
  std::filesystem::path store;
  FitRun fits;
  UvChart chart;
  BaseLayout layout;
  std::vector<Eigen::Vector3i> layout_triangles;
};

AdaptWorld make_adapt_world(const BenchWorld& bench);
/// Fitted ones, the real scan first.
std::vector<std::string> list_adapt_subjects(const AdaptWorld& world);
AdaptSubject load_adapt_subject(const AdaptWorld& world, const std::string& name);

/// A mesh made by one criterion on the subject's face base.
struct AdaptedMesh {
  TriangleMesh mesh;
  AdaptReport report;
  int vertices() const { return static_cast<int>(mesh.vertex_count()); }
};
AdaptedMesh run_criterion(const AdaptWorld& world, const AdaptSubject& subject,
                          const CriterionOptions& options, std::optional<int> ordered_vertices = {});

/// Distance both ways between an adapted mesh and all of a surface's vertices and triangles, measured with
/// SurfaceIndex alone: the mesh is sampled at 28 places a triangle.
struct Hausdorff {
  double from_surface_mm = 0, from_mesh_mm = 0;
  double both() const { return std::max(from_surface_mm, from_mesh_mm); }
};
Hausdorff measure_hausdorff(const TriangleMesh& mesh, std::span<const Eigen::Vector3f> surface,
                            const SurfaceIndex& surface_index);

double processor_seconds();  ///< of this thread

void measure_bases(const AdaptWorld& world);        ///< adapt_accuracy.cpp
void measure_equal_error(const AdaptWorld& world);  ///< adapt_accuracy.cpp
void measure_adapt_speed(const AdaptWorld& world);  ///< adapt_speed.cpp
void measure_operators(const AdaptWorld& world);    ///< adapt_operators.cpp
void measure_walk(const AdaptWorld& world);         ///< adapt_operators.cpp
void measure_clip(const AdaptWorld& world);         ///< adapt_clip.cpp

}  // namespace phiz::bench
