#include "formats/muscle_file.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/text.h"

namespace phiz {
namespace {

using Json = nlohmann::json;

/// The members of an object, each asked for once; what is left over is unknown.
class Members {
 public:
  Members(const Json& object, std::string path) : object_(object), path_(std::move(path)) {
    if (!object.is_object()) throw FormatError("is not an object (" + path_ + ")");
  }

  const Json* find(const char* key) {
    asked_.emplace_back(key);
    const auto found = object_.find(key);
    return found == object_.end() ? nullptr : &*found;
  }
  const Json& get(const char* key) {
    const Json* value = find(key);
    if (value == nullptr) throw FormatError("missing key '" + std::string(key) + "' (" + path_ + ")");
    return *value;
  }
  std::string place(const char* key) const { return path_ + "." + key; }

  void take(const char* key, double& to) {
    if (const Json* value = find(key)) to = number(*value, place(key));
  }
  void take(const char* key, int& to) {
    double wide = to;
    take(key, wide);
    if (wide != std::floor(wide) || std::abs(wide) > 1000)
      throw FormatError("is no small whole number (" + place(key) + ")");
    to = static_cast<int>(wide);
  }
  void take(const char* key, bool& to) {
    const Json* value = find(key);
    if (value == nullptr) return;
    if (!value->is_boolean()) throw FormatError("is not true or false (" + place(key) + ")");
    to = value->get<bool>();
  }
  void take(const char* key, std::string& to) {
    const Json* value = find(key);
    if (value != nullptr) to = text(*value, place(key));
  }
  void take(const char* key, Eigen::Vector3d& to) {
    const Json* value = find(key);
    if (value == nullptr) return;
    if (!value->is_array() || value->size() != 3)
      throw FormatError("is not three numbers (" + place(key) + ")");
    for (int c = 0; c < 3; ++c) to[c] = number((*value)[c], place(key));
  }
  void take(const char* key, std::vector<std::string>& to) {
    const Json* value = find(key);
    if (value == nullptr) return;
    if (!value->is_array() || value->size() > 1000) throw FormatError("is not a list (" + place(key) + ")");
    for (const Json& entry : *value) to.push_back(text(entry, place(key)));
  }
  void take(const char* key, std::map<std::string, double>& to) {
    const Json* value = find(key);
    if (value == nullptr) return;
    if (!value->is_object()) throw FormatError("is not an object (" + place(key) + ")");
    for (const auto& [name, weight] : value->items())
      to[name] = number(weight, place(key).append(".").append(name));
  }

  void finish() const {
    for (const auto& [key, value] : object_.items()) {
      if (std::find(asked_.begin(), asked_.end(), key) == asked_.end())
        throw FormatError("unknown key '" + key + "' (" + path_ + ")");
    }
  }

  static double number(const Json& value, const std::string& path) {
    if (!value.is_number()) throw FormatError("is not a number (" + path + ")");
    const double wide = value.get<double>();
    if (!(std::abs(wide) <= 1e6)) throw FormatError("is not a number in range (" + path + ")");
    return wide;
  }
  static std::string text(const Json& value, const std::string& path) {
    if (!value.is_string()) throw FormatError("is not a text (" + path + ")");
    return value.get<std::string>();
  }

 private:
  const Json& object_;
  std::string path_;
  std::vector<std::string> asked_;
};

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

Json parse_root(std::istream& in, const char* schema) {
  Json root;
  try {
    root = Json::parse(read_all(in));
  } catch (const Json::parse_error& error) {
    throw FormatError("is not JSON (byte " + std::to_string(error.byte) + ")");
  } catch (const Json::exception&) {
    throw FormatError("is not JSON with numbers in range");
  }
  if (!root.is_object() || root.value("schema", Json()) != schema)
    throw FormatError("is not \"" + std::string(schema) + "\" (schema)");
  return root;
}

template <typename Value, typename Parse>
void parse_list(Members& members, const char* key, std::vector<Value>& to, const Parse& parse) {
  const Json* list = members.find(key);
  if (list == nullptr) return;
  if (!list->is_array() || list->size() > 1000) throw FormatError("is not a list (" + std::string(key) + ")");
  for (const Json& entry : *list)
    to.push_back(parse(entry, std::string(key).append("[").append(std::to_string(to.size())).append("]")));
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
