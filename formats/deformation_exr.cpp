#include <algorithm>
#include <sstream>

#include "formats/deformation_parts.h"
#include "formats/error.h"
#include "formats/text.h"

namespace phiz {
namespace {

constexpr const char* kSchema = "phiz.deformation.1";
constexpr const char* kEmptyLayer = "mask.V";  ///< an EXR needs a channel: zero, where no field has an image

std::vector<std::string> layer_names(const DeformationField& field) {
  if (field.image.channels == 1) return {field.name + ".V"};
  return {field.name + ".X", field.name + ".Y", field.name + ".Z"};
}

/// A constant without an image is the subject's own surface; other empty images are zero.
bool has_layers(const DeformationField& field) {
  return !field.image.empty();
}

}  // namespace

FloatImage make_field_layers(const Deformation& deformation) {
  FloatImage image;
  image.width = deformation.width;
  image.height = deformation.height;
  image.attributes = {{"phizSchema", kSchema},
                      {"phizTemplate", deformation.template_digest},
                      {"phizUnits", "mm; masks without unit"},
                      {"phizGrid", "nodes: u = x / (width - 1), v = 1 - y / (height - 1)"}};
  const std::size_t count = static_cast<std::size_t>(image.width) * image.height;
  for (const DeformationField& field : deformation.fields) {
    if (!has_layers(field)) continue;
    const std::vector<float> values = expand_field_image(field.image, image.width, image.height);
    const std::vector<std::string> names = layer_names(field);
    for (std::size_t c = 0; c < names.size(); ++c) {
      std::vector<float>& layer = image.channels[names[c]];
      layer.resize(count);
      for (std::size_t i = 0; i < count; ++i) layer[i] = values[i * names.size() + c];
    }
  }
  if (image.channels.empty()) image.channels[kEmptyLayer].assign(count, 0.0f);
  return image;
}

void take_field_layers(const FloatImage& image, Deformation& deformation) {
  const auto attribute = [&](const char* name) {
    const auto found = image.attributes.find(name);
    return found == image.attributes.end() ? std::string() : found->second;
  };
  if (attribute("phizSchema") != kSchema) throw FormatError("the EXR is none of deformation fields");
  if (attribute("phizTemplate") != deformation.template_digest)
    throw FormatError("the EXR belongs to another generic head than the JSON");
  if (image.width != deformation.width || image.height != deformation.height) {
    throw FormatError("the EXR has " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                      " nodes, the JSON " + std::to_string(deformation.width) + " x " +
                      std::to_string(deformation.height));
  }
  std::size_t used = 0;
  std::vector<float> values;
  for (DeformationField& field : deformation.fields) {
    const std::vector<std::string> names = layer_names(field);
    if (!image.channels.contains(names[0])) continue;
    values.assign(image.channels.at(names[0]).size() * names.size(), 0.0f);
    for (std::size_t c = 0; c < names.size(); ++c) {
      const auto layer = image.channels.find(names[c]);
      if (layer == image.channels.end()) throw FormatError("the EXR lacks layer " + names[c]);
      for (std::size_t i = 0; i < layer->second.size(); ++i) values[i * names.size() + c] = layer->second[i];
    }
    used += names.size();
    field.image = crop_field_image(image.width, image.height, field.image.channels, values);
  }
  if (used == 0 && image.channels.size() == 1 && image.channels.contains(kEmptyLayer)) return;
  if (used != image.channels.size())
    throw FormatError("the EXR has layers of fields that the JSON does not name");
}

void write_deformation(const Deformation& deformation, std::ostream& json, std::ostream& exr) {
  check_deformation(deformation);
  write_exr(make_field_layers(deformation), exr);
  write_all(json, format_deformation_json(deformation));
}

Deformation read_deformation(std::istream& json, std::istream& exr) {
  Deformation deformation = parse_deformation_json(read_all(json));
  check_deformation(deformation);  // before the images: names and loops are the commoner faults
  take_field_layers(read_exr(exr), deformation);
  check_deformation(deformation);
  return deformation;
}

}  // namespace phiz
