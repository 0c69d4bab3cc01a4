#pragma once

#include <Eigen/Core>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "formats/deformation.h"

namespace phiz {

/// A designed muscle: where it pulls, whereto, how far it reaches. Lengths are in mm on the generic head,
/// axes those of the head (+y up, +z out of the face, +x to the subject's left).
struct MusclePull {
  LandmarkPoint centre;                                 ///< where it pulls most
  Eigen::Vector3d radii_mm = Eigen::Vector3d::Ones();   ///< of the ellipsoid beyond which nothing moves
  double plateau = 0;                                   ///< share of the radius that moves as one, [0, 1)
  std::optional<LandmarkPoint> toward;                  ///< the attachment: direction from the centre
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< without attachment; any length
  double amplitude_mm = 0;                              ///< along the direction at the centre
  double bulge_mm = 0;                                  ///< along the normal of the skin at the centre
  Eigen::Vector3d shrink = Eigen::Vector3d::Zero();     ///< towards the centre, share of the distance an axis
};

/// Lids that meet: every place of the upper margin goes to the line where both meet, what lies above follows
/// less and less; the lower lid likewise.
struct MuscleLids {
  std::vector<std::string> upper, lower;  ///< landmarks from corner to corner, both corners in both
  double meet = 0.15;                     ///< share of the gap that the lower lid comes up
  double upper_reach_mm = 12, lower_reach_mm = 8;
  double amount = 1;  ///< share of the gap that is closed; negative opens wider
};

/// A factor in [0,1]; all of a muscle's are multiplied.
struct MuscleMask {
  enum class Kind { kPlane, kRegion, kBelowCurve, kEllipsoid } kind = Kind::kPlane;
  bool is_inverted = false;
  LandmarkPoint point;                                ///< of the plane; middle of the ellipsoid
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  ///< of the plane: the mask is 1 on its side
  double offset_mm = 0;                               ///< moves the plane along its normal
  double blend_mm = 4;                                ///< half width of the plane's change from 0 to 1
  std::string region;                                 ///< of the generic head's annotations
  int shrink = 0;                                     ///< so many rings are taken off the region first
  int rings = 1;                                      ///< how often the region's border is averaged
  std::vector<std::string> curve;  ///< landmarks with ascending u: 1 below it in the (u,v) square
  double blend_uv = 0.02;          ///< half width of the change from 0 to 1 in the middle of the curve
  double straight = 1;             ///< up to this share of the way to the inner landmarks
  double blend_beyond = 0.5;       ///< its growth from there on, an u
  Eigen::Vector3d radii_mm = Eigen::Vector3d::Ones();
  double plateau = 0;
};

struct MuscleFile {
  std::string name;  ///< of the field and its parameter; a pair gets Left and Right behind it
  std::string doc;
  bool is_pair = false;                   ///< given for the left side; the right one is its mirror image
  FieldType type = FieldType::kAddLocal;  ///< or kRotate
  int stage = 0;                          ///< 0 skin, 1 jaw, 2 after the jaw; in this order in the cascade
  std::vector<MusclePull> pulls;
  std::optional<MuscleLids> lids;
  FieldAxis axis;        ///< of kRotate
  double angle_deg = 0;  ///< of kRotate
  std::vector<MuscleMask> masks;
  std::string scale_from,
      scale_to;          ///< landmarks whose distance on a subject scales the amount; may be empty
  double maximum = 1.1;  ///< of the parameter; motion files go slightly above 1
};

/// The rig: which muscles, and which name of a motion file moves which parameters.
struct RigFile {
  std::vector<std::string> muscles;  ///< files beside it, without .json, in the order of the cascade
  std::vector<RigControl> controls;
};

/// JSON; README.md documents the keys. Throw FormatError with the key.
MuscleFile read_muscle_file(std::istream& in);
RigFile read_rig_file(std::istream& in);

}  // namespace phiz
