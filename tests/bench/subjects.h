#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"

namespace phiz::bench {

/// One scan of the test data. Those under real/ have no truth.
struct BenchSubject {
  std::string name;  ///< of the subject in the store: the scan file's stem
  std::filesystem::path scan;
  std::filesystem::path truth;  ///< empty: none
  Eigen::Matrix4d scan_from_truth = Eigen::Matrix4d::Identity();
  double sample_pitch_scan = 0;  ///< distance of neighbouring samples in the scan's units; 0: unknown
  bool has_triangles = false;
  int points = 0;
};

/// What the truth's vertices are. Ranges are [0, last].
struct TruthLabels {
  int narrow_face_last = -1, face_last = -1;
  int skin_triangles = 0;  ///< the first ones are skin, the rest eyeballs
  std::vector<bool> is_hair;
  std::map<std::string, int> landmarks;  ///< name -> vertex
};

/// A folder of test data: everything is read from its subjects.json, truth/*.json and the listing of real/.
struct BenchData {
  std::filesystem::path folder;
  std::vector<BenchSubject> subjects;  ///< synthetic ones in order of name, then real ones
  TruthLabels labels;
};

/// $PHIZ_DATA, by default ../shared/data beside the source tree; none if there is no subjects.json. Throws
/// std::runtime_error where a file that subjects.json names is missing or not as expected.
std::optional<BenchData> find_bench_data();

/// A subject's truth in mm, in the truth's frame.
TriangleMesh load_truth(const BenchSubject& subject);

}  // namespace phiz::bench
