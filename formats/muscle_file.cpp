#include "formats/muscle_file.h"

#include "formats/error.h"
#include "formats/json_members.h"

namespace phiz {
namespace {

using namespace json_members;

void check_radii(const Eigen::Vector3d& radii, double plateau, const std::string& path) {
  if (!(radii.minCoeff() > 0)) throw FormatError("is not above 0 (" + path + ".radii_mm)");
  if (!(plateau >= 0 && plateau < 1)) throw FormatError("is not in [0, 1) (" + path + ".plateau)");
}

MusclePull parse_pull(const Json& json, const std::string& path) {
  Members members(json, path);
  MusclePull pull;
  members.get("centre"), members.get("radii_mm");
  members.take("centre", pull.centre);
  members.take("radii_mm", pull.radii_mm);
  members.take("plateau", pull.plateau);
  if (members.find("toward") != nullptr) members.take("toward", pull.toward.emplace());
  members.take("direction", pull.direction);
  members.take("amplitude_mm", pull.amplitude_mm);
  members.take("bulge_mm", pull.bulge_mm);
  members.take("shrink", pull.shrink);
  members.finish();
  check_radii(pull.radii_mm, pull.plateau, path);
  if (pull.amplitude_mm != 0 && !pull.toward && !(pull.direction.norm() > 0))
    throw FormatError("an amplitude needs a direction or an attachment (" + path + ")");
  return pull;
}

MuscleLids parse_lids(const Json& json) {
  Members members(json, "lids");
  MuscleLids lids;
  members.take("upper", lids.upper);
  members.take("lower", lids.lower);
  members.take("meet", lids.meet);
  members.take("upper_reach_mm", lids.upper_reach_mm);
  members.take("lower_reach_mm", lids.lower_reach_mm);
  members.take("amount", lids.amount);
  members.finish();
  if (lids.upper.size() < 3 || lids.lower.size() < 3)
    throw FormatError("needs three landmarks a lid or more (lids)");
  if (!(lids.upper_reach_mm > 0 && lids.lower_reach_mm > 0)) throw FormatError("reach is not above 0 (lids)");
  return lids;
}

MuscleMask parse_mask(const Json& json, const std::string& path) {
  Members members(json, path);
  MuscleMask mask;
  std::string kind;
  members.take("kind", kind);
  if (kind == "plane")
    mask.kind = MuscleMask::Kind::kPlane;
  else if (kind == "region")
    mask.kind = MuscleMask::Kind::kRegion;
  else if (kind == "below_curve")
    mask.kind = MuscleMask::Kind::kBelowCurve;
  else if (kind == "ellipsoid")
    mask.kind = MuscleMask::Kind::kEllipsoid;
  else
    throw FormatError("is not plane, region, below_curve or ellipsoid (" + path + ".kind)");
  members.take("invert", mask.is_inverted);
  members.take("point", mask.point);
  members.take("normal", mask.normal);
  members.take("offset_mm", mask.offset_mm);
  members.take("blend_mm", mask.blend_mm);
  members.take("region", mask.region);
  members.take("shrink", mask.shrink);
  members.take("rings", mask.rings);
  members.take("curve", mask.curve);
  members.take("blend_uv", mask.blend_uv);
  members.take("blend_beyond", mask.blend_beyond);
  members.take("straight", mask.straight);
  members.take("radii_mm", mask.radii_mm);
  members.take("plateau", mask.plateau);
  members.finish();
  check_radii(mask.radii_mm, mask.plateau, path);
  const bool is_sound = mask.blend_mm > 0 && mask.blend_uv > 0 && mask.blend_beyond >= 0 &&
                        mask.normal.norm() > 0 && mask.rings >= 0 && mask.rings <= 50 && mask.shrink >= 0 &&
                        mask.shrink <= 50;
  if (!is_sound) throw FormatError("a width, normal or count is out of range (" + path + ")");
  if (mask.kind == MuscleMask::Kind::kBelowCurve && mask.curve.size() < 2)
    throw FormatError("a curve needs two landmarks or more (" + path + ")");
  return mask;
}

}  // namespace

MuscleFile read_muscle_file(std::istream& in) {
  const Json root = parse_root(in, "phiz.muscle.1");
  Members members(root, "muscle");
  MuscleFile muscle;
  std::string type = "add_local";
  members.get("schema"), members.get("name");
  members.take("name", muscle.name);
  members.take("doc", muscle.doc);
  members.take("pair", muscle.is_pair);
  members.take("type", type);
  if (type != "add_local" && type != "rotate") throw FormatError("is not add_local or rotate (type)");
  muscle.type = type == "rotate" ? FieldType::kRotate : FieldType::kAddLocal;
  members.take("stage", muscle.stage);
  if (muscle.stage < 0 || muscle.stage > 2) throw FormatError("is not 0, 1 or 2 (stage)");
  parse_list(members, "pulls", muscle.pulls, parse_pull);
  if (const Json* lids = members.find("lids")) muscle.lids = parse_lids(*lids);
  if (const Json* json = members.find("axis")) {
    Members axis(*json, "axis");
    axis.take("from", muscle.axis.from);
    axis.take("to", muscle.axis.to);
    axis.finish();
  }
  members.take("angle_deg", muscle.angle_deg);
  parse_list(members, "masks", muscle.masks, parse_mask);
  if (const Json* json = members.find("scale")) {
    Members scale(*json, "scale");
    scale.take("from", muscle.scale_from);
    scale.take("to", muscle.scale_to);
    scale.finish();
  }
  members.take("maximum", muscle.maximum);
  members.finish();
  if (!(muscle.maximum > 0)) throw FormatError("is not above 0 (maximum)");
  if (muscle.type == FieldType::kRotate && (muscle.axis.from.empty() || muscle.axis.to.empty()))
    throw FormatError("a rotation needs an axis (axis)");
  return muscle;
}

RigFile read_rig_file(std::istream& in) {
  const Json root = parse_root(in, "phiz.rig.1");
  Members members(root, "rig");
  RigFile rig;
  members.get("schema");
  members.take("muscles", rig.muscles);
  const Json& controls = members.get("controls");
  members.finish();
  if (!controls.is_object()) throw FormatError("is not an object (controls)");
  for (const auto& [name, terms] : controls.items()) {
    RigControl control{name, {}, {}};
    Members weights(controls, "controls");
    weights.take(name.c_str(), control.terms);
    rig.controls.push_back(std::move(control));
  }
  return rig;
}

}  // namespace phiz
