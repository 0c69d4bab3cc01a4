#include "tests/stages/deform/deform_samples.h"

#include <cmath>

#include "tests/support/random.h"

namespace phiz::test {

FieldImage make_bump(int channels, int side, const Eigen::Vector2d& centre, double radius,
                     const Eigen::Vector3d& peak) {
  std::vector<float> values;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const Eigen::Vector2d uv(x / (side - 1.0), 1 - y / (side - 1.0));
      const double r = (uv - centre).norm() / radius;
      const double share = r < 1 ? (1 - r * r) * (1 - r * r) : 0;
      for (int c = 0; c < channels; ++c) values.push_back(static_cast<float>(share * peak[c]));
    }
  }
  return crop_field_image(side, side, channels, values);
}

Deformation make_sample_deformation(int side) {
  Deformation d;
  d.width = d.height = side;
  d.parameters = {{"smile", 0, 1.1}, {"raise", -0.5, 1}, {"open", 0, 1}, {"close", 0, 1}, {"mix", 0, 1}};
  const auto field = [&](const char* name, FieldType type, std::vector<std::string> inputs,
                         const char* parameter, FieldImage image) {
    DeformationField f;
    f.name = name, f.type = type, f.inputs = std::move(inputs), f.parameter = parameter;
    f.image = std::move(image);
    f.image.channels = field_channels(type);
    if (type == FieldType::kRotate) {
      f.axis = {{{"a", 0.5}, {"b", 0.5}}, {{"c", 1}}};
      f.gain = 0.35;
    }
    d.fields.push_back(std::move(f));
  };
  field("neutral", FieldType::kConstant, {}, "", {});
  field("smile", FieldType::kAddLocal, {"neutral"}, "smile", make_bump(3, side, {0.4, 0.3}, 0.3, {5, 8, -2}));
  field("raise", FieldType::kAdd, {"smile"}, "raise", make_bump(3, side, {0.6, 0.7}, 0.25, {0, 9, 1}));
  field("stretch", FieldType::kAddLocal, {"raise"}, "smile", make_bump(3, side, {0.5, 0.5}, 0.2, {-3, 0, 2}));
  field("jaw", FieldType::kRotate, {"stretch"}, "open", make_bump(1, side, {0.5, 0.2}, 0.5, {1, 0, 0}));
  field("lips", FieldType::kRotate, {"jaw"}, "close", make_bump(1, side, {0.5, 0.3}, 0.2, {-0.5, 0, 0}));
  field("far", FieldType::kConstant, {}, "", make_bump(3, side, {0.5, 0.5}, 0.6, {10, 20, 30}));
  field("mixed", FieldType::kBlend, {"lips", "far"}, "mix", make_bump(1, side, {0.2, 0.8}, 0.3, {0.7, 0, 0}));
  field("again", FieldType::kBlend, {"mixed", "smile"}, "mix",
        make_bump(1, side, {0.7, 0.2}, 0.3, {0.6, 0, 0}));
  d.fields[1].interpolation = FieldInterpolation::kBicubic;
  d.fields[1].scale = {"a", "c", 40};
  d.output = "again";
  d.controls = {{"mouthSmile", {"MouthSmile"}, {{"smile", 1.0}, {"raise", 0.25}}},
                {"jawOpen", {}, {{"open", 1.0}}}};
  return d;
}

NeutralSurface make_sample_surface(int count) {
  NeutralSurface neutral;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d uv(random().uniform(0, 1), random().uniform(0, 1));
    neutral.uv.push_back(uv);
    const Eigen::Vector3d p(180 * (uv.x() - 0.5), 200 * (uv.y() - 0.5),
                            40 * std::sin(3 * uv.x()) + 60 * uv.y());
    neutral.positions.push_back(p.cast<float>());
    const Eigen::AngleAxisd turn(0.3 * std::sin(5 * uv.x() + uv.y()), Eigen::Vector3d(1, 2, 3).normalized());
    neutral.frames.push_back(turn.toRotationMatrix().cast<float>());
  }
  neutral.landmarks = {{"a", {-60, 5, 0}}, {"b", {-50, -5, 8}}, {"c", {60, 1, 3}}};
  return neutral;
}

std::vector<double> draw_parameters(const Deformation& deformation) {
  std::vector<double> parameters;
  for (const DeformationParameter& parameter : deformation.parameters)
    parameters.push_back(random().uniform(parameter.minimum, parameter.maximum));
  return parameters;
}

}  // namespace phiz::test
