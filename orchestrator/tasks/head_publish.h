#pragma once

#include <map>
#include <optional>
#include <string>

namespace phiz {

struct HeadPublishOptions {
  double tolerance_mm = 0.02;  ///< of the surface, measured
  std::optional<int> level;    ///< finest level that is kept; absent: all
  int shown_level = 2;         ///< what viewers without the extension show; 0: the control mesh, for nothing
  bool with_confidences = false;  ///< in four classes
  std::map<std::string, std::string> provenance;
};

struct PublishedHead {
  std::string bytes;
  int level = 0, shown_level = 0;
  double hausdorff_mm = 0;  ///< measured: of its surface to the one it was made of, and back
};

/// The small head asset that leaves: displacements rounded to the tolerance level by level, read again and
/// evaluated before it is handed out. Throws FormatError, UsageError. 3 to 15 s at level 4.
PublishedHead publish_head(const std::string& asset_bytes, const HeadPublishOptions& options);

}  // namespace phiz
