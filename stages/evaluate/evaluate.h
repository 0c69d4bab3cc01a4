#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "formats/control_mesh.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {

/// Triangles that somebody else owns. All surfaces, clouds and landmarks of a comparison are in one frame,
/// mm.
struct SurfaceView {
  std::span<const Eigen::Vector3f> positions;
  std::span<const Eigen::Vector3i> triangles;
};

/// Distances in mm. All zero where nothing was counted. Percentiles are the smallest value that at least so
/// many percent do not exceed (nearest rank).
struct ErrorStats {
  std::size_t count = 0;
  double mean = 0, median = 0, p95 = 0, p99 = 0, max = 0;
};

/// Values must be finite. O(N log N).
ErrorStats compute_error_stats(std::span<const double> distances_mm);

using Regions = std::map<std::string, std::vector<bool>>;  ///< name -> one flag per vertex
using StatsByName = std::map<std::string, ErrorStats>;

/// Regions of the generic head on the vertices of `level`: a vertex between two of a region belongs to it.
/// Adds `face_and_ears` where there are both.
Regions refine_regions(const SubdivisionHierarchy& hierarchy, const Annotations& annotations, int level);

/// Diagonal of the box around the points, mm; 0 for none.
double compute_box_diagonal(std::span<const Eigen::Vector3f> points);

/// From each point to the nearest point of the surface, in the order of the points. Throws InvalidInput if
/// the surface has no triangle. Deterministic at any thread count. 300,000 points take about 0.2 s.
std::vector<double> compute_distances(std::span<const Eigen::Vector3f> points, const SurfaceView& surface);

/// Names of confidence classes, of the bytes of HeadAsset: measured (>= 192), bridged (>= 64), invented.
std::string name_confidence(std::uint8_t confidence);

/// What is known of the fitted vertices; both may be empty.
struct FittedLabels {
  Regions regions;
  std::vector<std::uint8_t> confidences;
};

struct SurfaceErrorOptions {
  double seen_mm = 1.0;   ///< a truth vertex counts if a point of the cloud is so near
  Regions truth_regions;  ///< of the truth's vertices; may be empty
};

/// Both ways. "By region" and "by confidence" sort a distance by the fitted vertex it starts from or, coming
/// from the truth, by the corner of the fitted triangle that is nearest to where it arrives; "by truth
/// region" by the truth's vertex likewise.
struct SurfaceErrors {
  ErrorStats truth_to_fitted;  ///< from the truth's vertices that the scan saw
  ErrorStats fitted_to_truth;  ///< from all fitted vertices
  StatsByName truth_to_fitted_by_region, fitted_to_truth_by_region;
  StatsByName truth_to_fitted_by_confidence, fitted_to_truth_by_confidence;
  StatsByName truth_to_fitted_by_truth_region;
};

/// Throws InvalidInput where a surface has no triangle or labels and vertices differ in number.
SurfaceErrors compute_surface_errors(const SurfaceView& fitted, const FittedLabels& labels,
                                     const SurfaceView& truth, std::span<const Eigen::Vector3f> cloud,
                                     const SurfaceErrorOptions& options = {});

/// Two fitted subjects, same indexing, and their truths, same indexing too. Each fit is in its truth's frame.
struct CorrespondencePair {
  std::span<const Eigen::Vector3f> fitted_a, fitted_b;
  std::span<const Eigen::Vector3f> truth_a, truth_b;
  std::span<const Eigen::Vector3i> truth_triangles;
};

struct CorrespondenceOptions {
  double reach_mm = 10.0;  ///< vertices farther from truth A have no true place and are not counted
  Regions regions;         ///< of the fitted vertices
  Regions truth_regions;   ///< of the truth's vertices
};

struct CorrespondenceErrors {
  ErrorStats all;
  StatsByName by_region, by_truth_region;
  std::vector<double> distances_mm;  ///< one a fitted vertex; NaN where not counted
};

/// Vertex i of A goes to the nearest place of truth A, by triangle and weights to truth B, and should meet
/// vertex i of B. Throws InvalidInput where numbers of vertices differ. Deterministic at any thread count.
CorrespondenceErrors compute_correspondence_errors(const CorrespondencePair& pair,
                                                   const CorrespondenceOptions& options = {});

/// Distances of the landmarks that both have, mm.
std::map<std::string, double> compute_landmark_errors(const std::map<std::string, Eigen::Vector3d>& fitted,
                                                      const std::map<std::string, Eigen::Vector3d>& truth);

}  // namespace phiz
