#pragma once

#include <Eigen/Core>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/deformation.h"

namespace phiz {

/// Places of the skin, and how far from them something holds, measured along the skin of the generic head (so
/// that lips and lids are far from each other): 1 within plateau * radius, 0 beyond the radius.
struct SkinZone {
  std::vector<LandmarkPoint> points;
  std::string region;  ///< instead of points: 1 in the region of the annotations, fading over the radius
  double radius_mm = 20;
  double plateau = 0;  ///< [0, 1)
};

/// How firmly skin is tied to bone.
struct SkinTie {
  enum class Kind {
    kSlack,  ///< takes `amount` (0 .. 1) of the tie to the skull away
    kSkull,  ///< ties to the skull, amount times as firm as elsewhere
    kJaw,    ///< ties to the jaw likewise, and takes the skull's away
  } kind = Kind::kSlack;
  SkinZone zone;
  bool is_pair = false;
  double amount = 1;
};

/// A rigid motion of the jaw at activation 1: a turn about the line through the condyles, then a slide.
struct JawMotion {
  std::string name;
  double turn_deg = 0;   ///< positive opens
  double twist_deg = 0;  ///< about +y through the middle of the condyles
  Eigen::Vector3d slide_mm = Eigen::Vector3d::Zero();
};

/// Edges of skin that meet and must not pass through each other: landmarks from corner to corner.
struct SkinRim {
  std::string name;
  bool is_pair = false;
  std::vector<std::string> upper, lower;
};

/// Flesh that keeps its volume.
struct SkinVolume {
  std::string name;
  bool is_pair = false;
  SkinZone zone;
  double stiffness = 1;
};

struct FaceMuscle {
  enum class Kind {
    kLinear,     ///< one fibre from bone to skin
    kSheet,      ///< several beside each other
    kSphincter,  ///< a ring that closes towards a line
  } kind = Kind::kLinear;
  std::string name;  ///< of its activation; a pair gets Left and Right behind it
  std::string doc;
  bool is_pair = false;                  ///< given for the left side; the right one is its mirror image
  double maximum = 1;                    ///< of the activation
  double radius_mm = 15, plateau = 0.2;  ///< how far from a fibre or from `line` skin is pulled, along it
  double way_mm = 0;                     ///< of the skin at full contraction: at the fibre's end, at the ring
  double bulge_mm = 0;                   ///< outwards in the middle of the fibre; of a sphincter, all over
  std::vector<std::vector<LandmarkPoint>> fibres;  ///< from bone to skin, two points or more each
  double depth_mm = 0;                             ///< of the bony end below the skin
  LandmarkPoint line_from, line_to;                ///< sphincter: the line it closes to
  double across = 1, along = 0;  ///< sphincter: shares of the way to the line, and to its middle
  SkinZone zone;                 ///< sphincter: what it pulls
  std::string retreat_region;    ///< tied to bone there, goes with it (the eye behind closing lids)
  Eigen::Vector3d retreat_mm = Eigen::Vector3d::Zero();
};

/// Named activations.
using Activations = std::map<std::string, double>;

/// Muscles, bones and flesh of a face on the generic head's landmarks.
struct FaceAnatomy {
  LandmarkPoint condyle_right, condyle_left;
  std::vector<JawMotion> jaw;
  std::vector<SkinTie> ties;         ///< each works on what the ones before it left
  std::vector<std::string> loose;    ///< regions whose skin hardly resists: the pocket of the mouth, the eyes
  std::vector<SkinRim> rims;
  std::vector<SkinVolume> volumes;
  std::vector<FaceMuscle> muscles;
  std::map<std::string, Activations> expressions;  ///< "smile"
  std::map<std::string, Activations> controls;     ///< names of motion files: what activates for one unit
};

/// JSON; README.md documents the keys. Throws FormatError with the key.
FaceAnatomy read_face_anatomy(std::istream& in);

/// The activations in order: jaw motions, then muscles, pairs as Left, Right.
std::vector<std::string> activation_names(const FaceAnatomy& anatomy);

}  // namespace phiz
