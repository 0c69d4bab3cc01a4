#include "formats/shape_space.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/image.h"
#include "formats/text.h"

namespace phiz {
namespace {

constexpr const char* kSchema = "phiz.shape_space.1";
constexpr std::size_t kMostComponents = 1000;
constexpr int kLargestSide = 4096;
constexpr char kAxes[] = "XYZ";

void check(const ShapeSpace& space) {
  if (space.width < 2 || space.height < 2 || space.width > kLargestSide || space.height > kLargestSide)
    throw FormatError("a shape space has a grid of 2 to 4096 nodes a side");
  const std::size_t count = static_cast<std::size_t>(space.width) * space.height;
  if (space.weights.size() != count || space.mean.size() != 3 * count)
    throw FormatError("mean or weights of the shape space have another size than its grid");
  for (const float weight : space.weights)
    if (!(std::isfinite(weight) && weight > 0))
      throw FormatError("a weight of the shape space is not above 0");
  if (space.components.size() > kMostComponents || space.variances.size() != space.components.size())
    throw FormatError("a shape space has one variance a component and at most 1000 of them");
  for (const auto& component : space.components)
    if (component.size() != 3 * count) throw FormatError("a component has another size than the grid");
  for (const double variance : space.variances)
    if (!(std::isfinite(variance) && variance >= 0)) throw FormatError("a variance is negative or no number");
  if (!(std::isfinite(space.total_variance) && space.total_variance >= 0))
    throw FormatError("the total variance is negative or no number");
  for (const auto& [name, coefficients] : space.subjects)
    if (coefficients.size() != space.components.size() ||
        !std::all_of(coefficients.begin(), coefficients.end(), [](double c) { return std::isfinite(c); }))
      throw FormatError("'" + name + "' has not one coefficient a component");
}

void put_layer(const std::string& name, const std::vector<float>& values, FloatImage& image) {
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float>& channel = image.channels[name + "." + kAxes[axis]];
    for (std::size_t i = axis; i < values.size(); i += 3) channel.push_back(values[i]);
  }
}

std::vector<float> take_layer(const std::string& name, const FloatImage& image) {
  std::vector<float> values(3 * static_cast<std::size_t>(image.width) * image.height);
  for (int axis = 0; axis < 3; ++axis) {
    const auto channel = image.channels.find(name + "." + kAxes[axis]);
    if (channel == image.channels.end()) throw FormatError("the EXR lacks layer " + name);
    for (std::size_t i = 0; i < channel->second.size(); ++i) values[3 * i + axis] = channel->second[i];
  }
  return values;
}

std::string component_name(std::size_t index) {
  const std::string digits = std::to_string(index);
  return "c" + std::string(digits.size() < 3 ? 3 - digits.size() : 0, '0') + digits;
}

}  // namespace

void write_shape_space(const ShapeSpace& space, std::ostream& json, std::ostream& exr) {
  check(space);
  nlohmann::ordered_json document = {{"schema", kSchema},
                                     {"template", space.template_digest},
                                     {"width", space.width},
                                     {"height", space.height},
                                     {"variances", space.variances},
                                     {"total_variance", space.total_variance},
                                     {"subjects", space.subjects}};
  FloatImage image;
  image.width = space.width;
  image.height = space.height;
  put_layer("mean", space.mean, image);
  image.channels["weight.V"] = space.weights;
  for (std::size_t k = 0; k < space.components.size(); ++k)
    put_layer(component_name(k), space.components[k], image);
  image.attributes = {{"phizSchema", kSchema},
                      {"phizUnits", "mean in mm, weights in mm^2"},
                      {"phizUv", "node (x,y) at u = x/(width-1), v = 1 - y/(height-1)"},
                      {"phizTemplate", space.template_digest}};
  write_exr(image, exr);
  write_all(json, document.dump(1) + "\n");
}

ShapeSpace read_shape_space(std::istream& json, std::istream& exr) {
  ShapeSpace space;
  try {
    const nlohmann::json document = nlohmann::json::parse(read_all(json));
    if (document.at("schema") != kSchema) throw FormatError("the JSON is none of a shape space (key schema)");
    space.template_digest = document.at("template").get<std::string>();
    space.width = document.at("width").get<int>();
    space.height = document.at("height").get<int>();
    space.variances = document.at("variances").get<std::vector<double>>();
    space.total_variance = document.at("total_variance").get<double>();
    space.subjects = document.at("subjects").get<std::map<std::string, std::vector<double>>>();
  } catch (const nlohmann::json::exception& error) {
    throw FormatError(std::string("the JSON is none of a shape space: ") + error.what());
  }
  if (space.variances.size() > kMostComponents)
    throw FormatError("a shape space has at most 1000 components");
  const FloatImage image = read_exr(exr);
  const auto schema = image.attributes.find("phizSchema"), digest = image.attributes.find("phizTemplate");
  if (schema == image.attributes.end() || schema->second != kSchema)
    throw FormatError("the EXR is none of a shape space (attribute phizSchema)");
  if ((digest == image.attributes.end() ? "" : digest->second) != space.template_digest)
    throw FormatError("the EXR belongs to another generic head than the JSON");
  if (image.width != space.width || image.height != space.height)
    throw FormatError("the EXR has another grid than the JSON");
  if (image.channels.size() != 4 + 3 * space.variances.size())
    throw FormatError("the EXR has layers that the JSON does not name, or lacks some");
  space.mean = take_layer("mean", image);
  const auto weights = image.channels.find("weight.V");
  if (weights == image.channels.end()) throw FormatError("the EXR lacks layer weight.V");
  space.weights = weights->second;
  for (std::size_t k = 0; k < space.variances.size(); ++k)
    space.components.push_back(take_layer(component_name(k), image));
  check(space);
  return space;
}

}  // namespace phiz
