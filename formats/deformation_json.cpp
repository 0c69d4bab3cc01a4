#include <cmath>
#include <nlohmann/json.hpp>

#include "formats/deformation_parts.h"
#include "formats/error.h"

namespace phiz {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSchema = "phiz.deformation.1";
constexpr std::size_t kMostEntries = 4096;

void check_keys(const Json& value, std::initializer_list<const char*> keys, const std::string& path) {
  if (!value.is_object()) throw FormatError("is not an object (" + path + ")");
  for (const char* key : keys) {
    if (!value.contains(key)) throw FormatError("missing key '" + std::string(key) + "' (" + path + ")");
  }
  if (value.size() == keys.size()) return;
  for (const auto& [key, member] : value.items()) {
    if (std::find_if(keys.begin(), keys.end(), [&](const char* k) { return key == k; }) == keys.end())
      throw FormatError("unknown key '" + key + "' (" + path + ")");
  }
}

double parse_double(const Json& value, const std::string& path) {
  if (!value.is_number()) throw FormatError("is not a number (" + path + ")");
  return value.get<double>();
}

int parse_side(const Json& value, const std::string& path) {
  const double number = parse_double(value, path);
  if (!(number >= 2 && number <= 8192) || number != std::floor(number))
    throw FormatError("is not from 2 to 8192 (" + path + ")");
  return static_cast<int>(number);
}

std::string parse_text(const Json& value, const std::string& path) {
  if (!value.is_string()) throw FormatError("is not a text (" + path + ")");
  return value.get<std::string>();
}

const Json& check_list(const Json& value, const std::string& path) {
  if (!value.is_array()) throw FormatError("is not a list (" + path + ")");
  if (value.size() > kMostEntries) throw FormatError("is too long (" + path + ")");
  return value;
}

std::vector<std::string> parse_texts(const Json& value, const std::string& path) {
  std::vector<std::string> texts;
  for (const Json& entry : check_list(value, path)) texts.push_back(parse_text(entry, path));
  return texts;
}

std::map<std::string, double> parse_weights(const Json& value, const std::string& path) {
  if (!value.is_object()) throw FormatError("is not an object (" + path + ")");
  std::map<std::string, double> weights;
  for (const auto& [name, weight] : value.items()) weights[name] = parse_double(weight, path + "." + name);
  return weights;
}

FieldType parse_type(const Json& value, const std::string& path) {
  const std::string name = parse_text(value, path);
  for (const FieldType type :
       {FieldType::kConstant, FieldType::kAdd, FieldType::kAddLocal, FieldType::kRotate, FieldType::kBlend}) {
    if (name == field_type_name(type)) return type;
  }
  throw FormatError("unknown field type '" + name + "' (" + path + ")",
                    "the types are constant, add, add_local, rotate and blend");
}

DeformationField parse_field(const Json& value, const std::string& path) {
  check_keys(value, {"name", "type", "on", "parameter", "gain", "interpolation", "axis", "scale", "origin"},
             path);
  DeformationField field;
  field.name = parse_text(value["name"], path + ".name");
  const std::string place = path + " '" + field.name + "'";
  field.type = parse_type(value["type"], place);
  field.inputs = parse_texts(value["on"], place + ".on");
  field.parameter = parse_text(value["parameter"], place + ".parameter");
  field.gain = parse_double(value["gain"], place + ".gain");
  const std::string interpolation = parse_text(value["interpolation"], place + ".interpolation");
  if (interpolation != "bilinear" && interpolation != "bicubic")
    throw FormatError("is not bilinear or bicubic (" + place + ".interpolation)");
  field.interpolation =
      interpolation == "bicubic" ? FieldInterpolation::kBicubic : FieldInterpolation::kBilinear;
  if (!value["axis"].is_null()) {
    check_keys(value["axis"], {"from", "to"}, place + ".axis");
    field.axis.from = parse_weights(value["axis"]["from"], place + ".axis.from");
    field.axis.to = parse_weights(value["axis"]["to"], place + ".axis.to");
  }
  if (!value["scale"].is_null()) {
    const Json& scale = value["scale"];
    check_keys(scale, {"from", "to", "reference_mm"}, place + ".scale");
    field.scale = {parse_text(scale["from"], place + ".scale.from"),
                   parse_text(scale["to"], place + ".scale.to"),
                   parse_double(scale["reference_mm"], place + ".scale.reference_mm")};
  }
  field.origin = parse_text(value["origin"], place + ".origin");
  field.image.channels = field_channels(field.type);
  return field;
}

Json to_json(const DeformationField& field) {
  Json axis, scale;
  if (field.type == FieldType::kRotate) axis = {{"from", field.axis.from}, {"to", field.axis.to}};
  if (!field.scale.from.empty()) {
    scale = {{"from", field.scale.from}, {"to", field.scale.to}, {"reference_mm", field.scale.reference_mm}};
  }
  return {{"name", field.name},
          {"type", field_type_name(field.type)},
          {"on", field.inputs},
          {"parameter", field.parameter},
          {"gain", field.gain},
          {"interpolation", field.interpolation == FieldInterpolation::kBicubic ? "bicubic" : "bilinear"},
          {"axis", axis},
          {"scale", scale},
          {"origin", field.origin}};
}

/// One entry a line.
std::string list_of(const std::vector<Json>& entries) {
  std::string text = "[";
  for (const Json& entry : entries) text += (text.size() > 1 ? ",\n    " : "\n    ") + entry.dump();
  return text + (entries.empty() ? "]" : "\n  ]");
}

Json parse_json(const std::string& text) {
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    throw FormatError("is not JSON (byte " + std::to_string(error.byte) + ")");
  } catch (const Json::exception&) {
    throw FormatError("is not JSON with numbers in range");
  }
}

}  // namespace

std::string format_deformation_json(const Deformation& deformation) {
  std::vector<Json> parameters, fields, controls;
  for (const DeformationParameter& parameter : deformation.parameters) {
    parameters.push_back(
        {{"name", parameter.name}, {"minimum", parameter.minimum}, {"maximum", parameter.maximum}});
  }
  for (const DeformationField& field : deformation.fields) fields.push_back(to_json(field));
  for (const RigControl& control : deformation.controls) {
    controls.push_back({{"name", control.name}, {"aliases", control.aliases}, {"terms", control.terms}});
  }
  std::string text = "{\n  \"schema\": \"" + std::string(kSchema) + "\",\n";
  text += "  \"template\": " + Json(deformation.template_digest).dump() + ",\n";
  text += "  \"width\": " + std::to_string(deformation.width) + ",\n";
  text += "  \"height\": " + std::to_string(deformation.height) + ",\n";
  text += "  \"parameters\": " + list_of(parameters) + ",\n";
  text += "  \"fields\": " + list_of(fields) + ",\n";
  text += "  \"output\": " + Json(deformation.output).dump() + ",\n";
  text += "  \"controls\": " + list_of(controls) + "\n}\n";
  return text;
}

Deformation parse_deformation_json(const std::string& text) {
  const Json root = parse_json(text);
  check_keys(root, {"schema", "template", "width", "height", "parameters", "fields", "output", "controls"},
             "deformation");
  if (root["schema"] != kSchema) throw FormatError("is not \"" + std::string(kSchema) + "\" (schema)");
  Deformation deformation;
  deformation.template_digest = parse_text(root["template"], "template");
  deformation.width = parse_side(root["width"], "width");
  deformation.height = parse_side(root["height"], "height");
  for (const Json& entry : check_list(root["parameters"], "parameters")) {
    const std::string path = "parameters[" + std::to_string(deformation.parameters.size()) + "]";
    check_keys(entry, {"name", "minimum", "maximum"}, path);
    deformation.parameters.push_back({parse_text(entry["name"], path + ".name"),
                                      parse_double(entry["minimum"], path + ".minimum"),
                                      parse_double(entry["maximum"], path + ".maximum")});
  }
  for (const Json& entry : check_list(root["fields"], "fields")) {
    deformation.fields.push_back(
        parse_field(entry, "fields[" + std::to_string(deformation.fields.size()) + "]"));
  }
  deformation.output = parse_text(root["output"], "output");
  for (const Json& entry : check_list(root["controls"], "controls")) {
    const std::string path = "controls[" + std::to_string(deformation.controls.size()) + "]";
    check_keys(entry, {"name", "aliases", "terms"}, path);
    deformation.controls.push_back({parse_text(entry["name"], path + ".name"),
                                    parse_texts(entry["aliases"], path + ".aliases"),
                                    parse_weights(entry["terms"], path + ".terms")});
  }
  return deformation;
}

}  // namespace phiz
