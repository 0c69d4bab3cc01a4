#include "formats/face_anatomy.h"

#include <set>

#include "formats/json_members.h"

namespace phiz {
namespace {

using namespace json_members;

std::vector<LandmarkPoint> parse_points(const Json& list, const std::string& path) {
  if (!list.is_array() || list.empty() || list.size() > 100)
    throw FormatError("is not a list of places (" + path + ")");
  std::vector<LandmarkPoint> points;
  for (const Json& entry : list) {
    if (!entry.is_object() || entry.empty()) throw FormatError("is no place of landmarks (" + path + ")");
    LandmarkPoint point;
    double sum = 0;
    for (const auto& [name, weight] : entry.items())
      sum += point[name] = Members::number(weight, std::string(path).append(".").append(name));
    if (std::abs(sum - 1) > 1e-6) throw FormatError("weights do not sum to 1 (" + path + ")");
    points.push_back(std::move(point));
  }
  return points;
}

LandmarkPoint parse_point(const Json& json, const std::string& path) {
  return parse_points(Json::array({json}), path).front();
}

SkinZone parse_zone(const Json& json, const std::string& path) {
  Members members(json, path);
  SkinZone zone;
  if (const Json* points = members.find("points")) zone.points = parse_points(*points, path + ".points");
  members.take("region", zone.region);
  members.take("radius_mm", zone.radius_mm);
  members.take("plateau", zone.plateau);
  members.finish();
  if (zone.points.empty() == zone.region.empty())
    throw FormatError("needs points or a region (" + path + ")");
  if (!(zone.radius_mm > 0) || !(zone.plateau >= 0 && zone.plateau < 1))
    throw FormatError("radius or plateau is out of range (" + path + ")");
  return zone;
}

JawMotion parse_jaw(const Json& json, const std::string& path) {
  Members members(json, path);
  JawMotion motion;
  members.get("name");
  members.take("name", motion.name);
  members.take("turn_deg", motion.turn_deg);
  members.take("twist_deg", motion.twist_deg);
  members.take("slide_mm", motion.slide_mm);
  members.finish();
  if (std::abs(motion.turn_deg) > 60 || std::abs(motion.twist_deg) > 60)
    throw FormatError("turns too far (" + path + ")");
  return motion;
}

SkinTie parse_tie(const Json& json, const std::string& path) {
  Members members(json, path);
  SkinTie tie;
  std::string kind;
  members.take("kind", kind);
  if (kind != "slack" && kind != "skull" && kind != "jaw")
    throw FormatError("is not slack, skull or jaw (" + path + ".kind)");
  tie.kind = kind == "slack"   ? SkinTie::Kind::kSlack
             : kind == "skull" ? SkinTie::Kind::kSkull
                               : SkinTie::Kind::kJaw;
  tie.zone = parse_zone(members.get("zone"), path + ".zone");
  members.take("pair", tie.is_pair);
  members.take("amount", tie.amount);
  members.finish();
  if (!(tie.amount >= 0 && tie.amount <= (tie.kind == SkinTie::Kind::kSlack ? 1 : 1000)))
    throw FormatError("is out of range (" + path + ".amount)");
  return tie;
}

SkinRim parse_rim(const Json& json, const std::string& path) {
  Members members(json, path);
  SkinRim rim;
  members.take("name", rim.name);
  members.take("pair", rim.is_pair);
  members.take("upper", rim.upper);
  members.take("lower", rim.lower);
  members.finish();
  if (rim.upper.size() < 2 || rim.lower.size() < 2)
    throw FormatError("needs two landmarks a side (" + path + ")");
  return rim;
}

SkinVolume parse_volume(const Json& json, const std::string& path) {
  Members members(json, path);
  SkinVolume volume;
  members.take("name", volume.name);
  members.take("pair", volume.is_pair);
  volume.zone = parse_zone(members.get("zone"), path + ".zone");
  members.take("stiffness", volume.stiffness);
  members.finish();
  if (!(volume.stiffness >= 0)) throw FormatError("is below 0 (" + path + ".stiffness)");
  return volume;
}

void parse_shape(Members& members, const std::string& path, FaceMuscle& muscle) {
  if (const Json* fibres = members.find("fibres")) {
    if (!fibres->is_array() || fibres->size() > 100) throw FormatError("is not a list (" + path + ".fibres)");
    for (const Json& fibre : *fibres) {
      muscle.fibres.push_back(parse_points(fibre, path + ".fibres"));
      if (muscle.fibres.back().size() < 2)
        throw FormatError("a fibre needs two places (" + path + ".fibres)");
    }
  }
  if (const Json* json = members.find("line")) {
    Members line(*json, path + ".line");
    muscle.line_from = parse_point(line.get("from"), path + ".line.from");
    muscle.line_to = parse_point(line.get("to"), path + ".line.to");
    line.finish();
  }
  if (const Json* zone = members.find("zone")) muscle.zone = parse_zone(*zone, path + ".zone");
  if (const Json* json = members.find("retreat")) {
    Members retreat(*json, path + ".retreat");
    retreat.get("region"), retreat.get("slide_mm");
    retreat.take("region", muscle.retreat_region);
    retreat.take("slide_mm", muscle.retreat_mm);
    retreat.finish();
  }
  const bool is_ring = muscle.kind == FaceMuscle::Kind::kSphincter;
  if (is_ring ? muscle.line_from.empty() || (muscle.zone.points.empty() && muscle.zone.region.empty())
              : muscle.fibres.empty())
    throw FormatError(is_ring ? "needs a line and a zone (" + path + ")" : "needs fibres (" + path + ")");
  if (muscle.kind == FaceMuscle::Kind::kLinear && muscle.fibres.size() != 1)
    throw FormatError("a linear muscle has one fibre (" + path + ")");
}

FaceMuscle parse_muscle(const Json& json, const std::string& path) {
  Members members(json, path);
  FaceMuscle muscle;
  std::string kind;
  members.get("name"), members.get("kind");
  members.take("name", muscle.name);
  members.take("doc", muscle.doc);
  members.take("kind", kind);
  if (kind != "linear" && kind != "sheet" && kind != "sphincter")
    throw FormatError("is not linear, sheet or sphincter (" + path + ".kind)");
  muscle.kind = kind == "linear"  ? FaceMuscle::Kind::kLinear
                : kind == "sheet" ? FaceMuscle::Kind::kSheet
                                  : FaceMuscle::Kind::kSphincter;
  members.take("pair", muscle.is_pair);
  members.take("maximum", muscle.maximum);
  members.take("radius_mm", muscle.radius_mm);
  members.take("plateau", muscle.plateau);
  members.take("way_mm", muscle.way_mm);
  members.take("bulge_mm", muscle.bulge_mm);
  members.take("depth_mm", muscle.depth_mm);
  members.take("across", muscle.across);
  members.take("along", muscle.along);
  parse_shape(members, path, muscle);
  members.finish();
  const bool is_sound = muscle.maximum > 0 && muscle.radius_mm > 0 && muscle.plateau >= 0 &&
                        muscle.plateau < 1 && std::abs(muscle.way_mm) <= 100 &&
                        std::abs(muscle.bulge_mm) <= 100;
  if (!is_sound) throw FormatError("a number is out of range (" + path + ")");
  return muscle;
}

/// {"smile": {"zygomaticMajorLeft": 0.8}}; every activation has to be there.
std::map<std::string, Activations> parse_poses(Members& root, const char* key,
                                               const std::set<std::string>& names) {
  std::map<std::string, Activations> poses;
  const Json* object = root.find(key);
  if (object == nullptr) return poses;
  if (!object->is_object()) throw FormatError("is not an object (" + std::string(key) + ")");
  Members members(*object, key);
  for (const auto& entry : object->items()) {
    Activations& pose = poses[entry.key()];
    members.take(entry.key().c_str(), pose);
    for (const auto& activation : pose)
      if (!names.contains(activation.first))
        throw FormatError("no muscle or jaw motion '" + activation.first + "' (" + std::string(key) + "." +
                          entry.key() + ")");
  }
  return poses;
}

}  // namespace

std::vector<std::string> activation_names(const FaceAnatomy& anatomy) {
  std::vector<std::string> names;
  for (const JawMotion& motion : anatomy.jaw) names.push_back(motion.name);
  for (const FaceMuscle& muscle : anatomy.muscles) {
    if (!muscle.is_pair) names.push_back(muscle.name);
    if (muscle.is_pair) names.insert(names.end(), {muscle.name + "Left", muscle.name + "Right"});
  }
  return names;
}

FaceAnatomy read_face_anatomy(std::istream& in) {
  const Json root = parse_root(in, "phiz.anatomy.1");
  Members members(root, "anatomy");
  FaceAnatomy anatomy;
  members.get("schema");
  {
    Members condyles(members.get("condyles"), "condyles");
    anatomy.condyle_right = parse_point(condyles.get("right"), "condyles.right");
    anatomy.condyle_left = parse_point(condyles.get("left"), "condyles.left");
    condyles.finish();
  }
  parse_list(members, "jaw", anatomy.jaw, parse_jaw);
  parse_list(members, "ties", anatomy.ties, parse_tie);
  members.take("loose", anatomy.loose);
  parse_list(members, "rims", anatomy.rims, parse_rim);
  parse_list(members, "volumes", anatomy.volumes, parse_volume);
  parse_list(members, "muscles", anatomy.muscles, parse_muscle);
  std::set<std::string> names;
  for (const std::string& name : activation_names(anatomy))
    if (name.empty() || !names.insert(name).second)
      throw FormatError("the name '" + name + "' is empty or there twice");
  anatomy.expressions = parse_poses(members, "expressions", names);
  anatomy.controls = parse_poses(members, "controls", names);
  members.finish();
  return anatomy;
}

}  // namespace phiz
