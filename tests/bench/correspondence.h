#pragma once

#include <map>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"
#include "tests/bench/fitted.h"
#include "tests/bench/subjects.h"

namespace phiz::bench {

/// A fitted subject in its truth's frame.
struct Placed {
  std::string name;
  TriangleMesh truth;
  Positions vertices;  ///< of the finished surface at kCorrespondenceLevel
  Positions finest;    ///< at the finest level
};

constexpr int kCorrespondenceLevel = 2;

/// Distances in mm between vertex i of B and vertex i of A carried through the truth to B: to the nearest
/// place of A's true skin, and to the same place of B's. Over all ordered pairs.
struct Correspondence {
  double narrow_face =
      0;  ///< vertices whose nearest true place is in the narrow face, mouth pocket and nostrils out
  double narrow_face_all = 0;             ///< those too
  std::map<std::string, double> regions;  ///< of the generic head: ears, lips, eyelids, nose
  std::size_t pairs = 0;
};

Correspondence measure_correspondence(const std::vector<Placed>& subjects, const GenericHead& head,
                                      const TruthLabels& labels);

/// Mean distance in mm between a landmark of the generic head on the fitted subjects and the truth's, by
/// name; the 68 of the usual set, not the ears'.
std::map<std::string, double> measure_landmarks(const std::vector<Placed>& subjects, const GenericHead& head,
                                                const TruthLabels& labels);

}  // namespace phiz::bench
