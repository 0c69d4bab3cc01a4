#include "stages/deform/muscles.h"

#include <cmath>
#include <numbers>

#include "stages/deform/muscle_shapes.h"
#include "stages/geometry/error.h"

namespace phiz {
namespace {

using Eigen::Vector3d;

constexpr double kLeastMm = 1e-4;  ///< below this a field is zero: half a step of the compiled cascade

FieldImage image_of(const UvCanvas& canvas, const std::vector<Vector3d>& drawn, FieldType type,
                    bool is_mirrored) {
  const int side = canvas.side, channels = field_channels(type);
  std::vector<float> values(drawn.size() * channels, 0.0f);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      Vector3d value = drawn[static_cast<std::size_t>(y) * side + (is_mirrored ? side - 1 - x : x)];
      if (is_mirrored && channels == 3) value.x() = -value.x();
      if (value.cwiseAbs().maxCoeff() < kLeastMm) continue;
      for (int c = 0; c < channels; ++c)
        values[(static_cast<std::size_t>(y) * side + x) * channels + c] = static_cast<float>(value[c]);
    }
  }
  return crop_field_image(side, side, channels, values);
}

std::string other_side(const std::string& name) {
  for (const auto& [from, to] : {std::pair{"_left", "_right"}, std::pair{"_right", "_left"}}) {
    const std::size_t at = name.find(from);
    if (at != std::string::npos) return name.substr(0, at) + to + name.substr(at + std::string(from).size());
  }
  return name;
}

LandmarkPoint other_side(const LandmarkPoint& point) {
  LandmarkPoint other;
  for (const auto& [name, weight] : point) other[other_side(name)] += weight;
  return other;
}

DeformationField make_field(const UvCanvas& canvas, const MuscleFile& muscle,
                            const std::vector<Vector3d>& drawn, const std::string& suffix) {
  const bool is_mirrored = suffix == "Right";
  DeformationField field;
  field.name = muscle.name + suffix;
  field.parameter = field.name;
  field.type = muscle.type;
  field.image = image_of(canvas, drawn, muscle.type, is_mirrored);
  field.origin = "designed: muscles/" + muscle.name;
  if (muscle.type == FieldType::kRotate) {
    field.gain = muscle.angle_deg * std::numbers::pi / 180 * (is_mirrored ? -1 : 1);
    field.axis =
        is_mirrored ? FieldAxis{other_side(muscle.axis.from), other_side(muscle.axis.to)} : muscle.axis;
  }
  if (!muscle.scale_from.empty()) {
    const auto end = [&](const std::string& name) { return is_mirrored ? other_side(name) : name; };
    field.scale = {end(muscle.scale_from), end(muscle.scale_to), 0};
    const auto from = canvas.landmarks.find(field.scale.from), to = canvas.landmarks.find(field.scale.to);
    if (from == canvas.landmarks.end() || to == canvas.landmarks.end())
      throw InvalidInput("the generic head has no landmark '" + field.scale.from + "' or '" + field.scale.to +
                         "'");
    field.scale.reference_mm = (from->second - to->second).norm();
  }
  return field;
}

std::vector<std::string> aliases_of(const std::string& name) {
  std::vector<std::string> aliases;
  if (name.empty() || name[0] < 'a' || name[0] > 'z') return aliases;
  std::string pascal = name;
  pascal[0] = static_cast<char>(pascal[0] - 'a' + 'A');
  aliases.push_back(pascal);
  for (const auto& [side, letter] :
       {std::pair{std::string("Left"), "_L"}, std::pair{std::string("Right"), "_R"}}) {
    const bool has_stem =
        name.size() > side.size() && name.ends_with(side) && name != "jaw" + side && name != "mouth" + side;
    if (has_stem) aliases.push_back(name.substr(0, name.size() - side.size()) + letter);
  }
  return aliases;
}

}  // namespace

Deformation build_muscles(const ControlMesh& generic_head, std::span<const MuscleFile> muscles,
                          const RigFile& rig, const MuscleOptions& options) {
  if (options.side < 16 || options.side > 4096)
    throw InvalidInput("the grid is not from 16 to 4096 nodes a side");
  const UvCanvas canvas = draw_uv_canvas(generic_head, options.side);
  Deformation deformation;
  deformation.width = deformation.height = options.side;
  DeformationField neutral;
  neutral.name = "neutral";
  neutral.type = FieldType::kConstant;
  neutral.origin = "the subject's own surface";
  deformation.fields.push_back(neutral);
  for (int stage = 0; stage <= 2; ++stage) {
    for (const MuscleFile& muscle : muscles) {
      if (muscle.stage != stage) continue;
      try {
        const std::vector<Vector3d> drawn = draw_muscle(generic_head, canvas, muscle);
        std::vector<std::string> sides = {""};
        if (muscle.is_pair) sides = {"Left", "Right"};
        for (const std::string& suffix : sides) {
          DeformationField field = make_field(canvas, muscle, drawn, suffix);
          field.inputs = {deformation.fields.back().name};
          deformation.parameters.push_back({field.name, 0, muscle.maximum});
          deformation.fields.push_back(std::move(field));
        }
      } catch (const InvalidInput& error) {
        throw InvalidInput("muscle '" + muscle.name + "': " + error.what());
      }
    }
  }
  deformation.output = deformation.fields.back().name;
  for (RigControl control : rig.controls) {
    control.aliases = aliases_of(control.name);
    deformation.controls.push_back(std::move(control));
  }
  check_deformation(deformation);
  return deformation;
}

}  // namespace phiz
