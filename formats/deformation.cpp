#include "formats/deformation.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "formats/deformation_parts.h"
#include "formats/error.h"

namespace phiz {
namespace {

constexpr int kLargestSide = 8192;
constexpr std::size_t kLongestName = 64;

bool is_name(const std::string& name) {
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  return !name.empty() && name.size() <= kLongestName && name[0] >= 'a' && name[0] <= 'z' &&
         std::all_of(name.begin(), name.end(), is_letter);
}

/// Control names come from elsewhere: anything printable that needs no quoting.
bool is_control_name(const std::string& name) {
  return !name.empty() && name.size() <= kLongestName && std::all_of(name.begin(), name.end(), [](char c) {
    return c > ' ' && c < 127 && c != '"' && c != '\\' && c != ',';
  });
}

void check_place(const LandmarkPoint& point, const std::string& what) {
  double sum = 0;
  for (const auto& [landmark, weight] : point) {
    if (!is_control_name(landmark) || !std::isfinite(weight))
      throw FormatError(what + ": no landmark and weight");
    sum += weight;
  }
  if (!(std::abs(sum - 1) < 1e-6)) throw FormatError(what + ": weights of landmarks do not sum to 1");
}

void check_field_image(const Deformation& deformation, const DeformationField& field) {
  const std::string what = "field '" + field.name + "': ";
  const FieldImage& image = field.image;
  if (image.channels != field_channels(field.type)) throw FormatError(what + "image of the wrong channels");
  const bool inside = image.x >= 0 && image.y >= 0 && image.width >= 0 && image.height >= 0 &&
                      image.width <= deformation.width - image.x &&
                      image.height <= deformation.height - image.y;
  if (!inside) throw FormatError(what + "image beyond the grid");
  if (image.values.size() != static_cast<std::size_t>(image.width) * image.height * image.channels) {
    throw FormatError(what + "image is not of its size");
  }
  for (const float value : image.values) {
    if (!(std::abs(value) <= 1e6f))
      throw FormatError(what + "image has a value that is not finite or absurd");
  }
}

void check_field(const Deformation& deformation, const DeformationField& field,
                 const std::set<std::string>& parameters) {
  if (!is_name(field.name)) throw FormatError("'" + field.name + "' cannot be a field's name");
  const std::string what = "field '" + field.name + "'";
  const std::size_t inputs = field.type == FieldType::kConstant ? 0 : field.type == FieldType::kBlend ? 2 : 1;
  if (field.inputs.size() != inputs) {
    throw FormatError(what + ": works on " + std::to_string(field.inputs.size()) + " fields, type " +
                      field_type_name(field.type) + " on " + std::to_string(inputs));
  }
  if (field.type == FieldType::kConstant && !field.parameter.empty())
    throw FormatError(what + ": a constant has no parameter");
  if (!field.parameter.empty() && !parameters.contains(field.parameter))
    throw FormatError(what + ": no parameter '" + field.parameter + "'");
  if (!std::isfinite(field.gain)) throw FormatError(what + ": gain is not finite");
  if (field.origin.size() > 200 ||
      std::any_of(field.origin.begin(), field.origin.end(), [](char c) { return c < ' ' || c > '~'; }))
    throw FormatError(what + ": origin is no plain line");
  if (field.type == FieldType::kRotate) {
    check_place(field.axis.from, what + ": axis from");
    check_place(field.axis.to, what + ": axis to");
  }
  const bool is_scaled = !field.scale.from.empty() || !field.scale.to.empty();
  if (is_scaled && (!is_control_name(field.scale.from) || !is_control_name(field.scale.to) ||
                    !(field.scale.reference_mm > 0) || !std::isfinite(field.scale.reference_mm)))
    throw FormatError(what + ": scale needs two landmarks and a length");
  check_field_image(deformation, field);
}

void check_parameters(const Deformation& deformation, std::set<std::string>& names) {
  for (const DeformationParameter& parameter : deformation.parameters) {
    if (!is_name(parameter.name)) throw FormatError("'" + parameter.name + "' cannot be a parameter's name");
    if (!names.insert(parameter.name).second) throw FormatError("parameter '" + parameter.name + "' twice");
    if (!(parameter.minimum <= 0 && parameter.maximum >= 0 && parameter.maximum - parameter.minimum < 1e6))
      throw FormatError("parameter '" + parameter.name + "': its range does not hold 0");
  }
}

void check_controls(const Deformation& deformation, const std::set<std::string>& parameters) {
  std::set<std::string> names;
  for (const RigControl& control : deformation.controls) {
    std::vector<std::string> all = control.aliases;
    all.push_back(control.name);
    for (const std::string& name : all) {
      if (!is_control_name(name)) throw FormatError("'" + name + "' cannot be a control's name");
      if (!names.insert(name).second) throw FormatError("control name '" + name + "' twice");
    }
    for (const auto& [parameter, weight] : control.terms) {
      if (!parameters.contains(parameter))
        throw FormatError("control '" + control.name + "': no parameter '" + parameter + "'");
      if (!std::isfinite(weight)) throw FormatError("control '" + control.name + "': weight is not finite");
    }
  }
}

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row.back();
}

}  // namespace

int field_channels(FieldType type) {
  return type == FieldType::kRotate || type == FieldType::kBlend ? 1 : 3;
}

const char* field_type_name(FieldType type) {
  switch (type) {
    case FieldType::kConstant:
      return "constant";
    case FieldType::kAdd:
      return "add";
    case FieldType::kAddLocal:
      return "add_local";
    case FieldType::kRotate:
      return "rotate";
    case FieldType::kBlend:
      break;
  }
  return "blend";
}

void check_deformation(const Deformation& deformation) {
  const bool sized = deformation.width >= 2 && deformation.height >= 2 && deformation.width <= kLargestSide &&
                     deformation.height <= kLargestSide;
  if (!sized) throw FormatError("grid is not from 2 to " + std::to_string(kLargestSide));
  const auto is_hex = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  const std::string& digest = deformation.template_digest;
  if (!std::all_of(digest.begin(), digest.end(), is_hex)) throw FormatError("template digest is none");
  std::set<std::string> parameters;
  check_parameters(deformation, parameters);
  check_controls(deformation, parameters);
  std::set<std::string> names;
  for (const DeformationField& field : deformation.fields) {
    check_field(deformation, field, parameters);
    if (!names.insert(field.name).second) throw FormatError("field '" + field.name + "' twice");
  }
  for (const DeformationField& field : deformation.fields) {
    for (const std::string& input : field.inputs) {
      if (!names.contains(input))
        throw FormatError("field '" + field.name + "': works on '" + input + "', which is not there");
    }
  }
  compute_cascade_order(deformation);
}

std::vector<int> compute_cascade_order(const Deformation& deformation) {
  std::map<std::string, int> index;
  for (const DeformationField& field : deformation.fields)
    index.emplace(field.name, static_cast<int>(index.size()));
  if (!index.contains(deformation.output))
    throw FormatError("no field '" + deformation.output + "' (output)");
  enum class State { kNew, kOpen, kDone };
  std::vector<State> states(deformation.fields.size(), State::kNew);
  std::vector<int> order, stack = {index.at(deformation.output)};
  while (!stack.empty()) {
    const int at = stack.back();
    const DeformationField& field = deformation.fields[at];
    states[at] = states[at] == State::kDone ? State::kDone : State::kOpen;
    int next = -1;
    for (const std::string& input : field.inputs) {
      const auto found = index.find(input);
      if (found == index.end())
        throw FormatError("field '" + field.name + "': works on '" + input + "', which is not there");
      if (states[found->second] == State::kOpen)
        throw FormatError("fields work on each other in a loop: '" + field.name + "' on '" + input + "'");
      if (next < 0 && states[found->second] == State::kNew) next = found->second;
    }
    if (next >= 0) {
      stack.push_back(next);
      continue;
    }
    stack.pop_back();
    if (states[at] != State::kDone) order.push_back(at);
    states[at] = State::kDone;
  }
  return order;
}

FieldImage crop_field_image(int width, int height, int channels, const std::vector<float>& values) {
  FieldImage image;
  image.channels = channels;
  int left = width, right = -1, top = height, bottom = -1;
  const auto at = [&](int x, int y, int c) {
    return values[(static_cast<std::size_t>(y) * width + x) * channels + c];
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      bool is_zero = true;
      for (int c = 0; c < channels; ++c) is_zero = is_zero && at(x, y, c) == 0;
      if (is_zero) continue;
      left = std::min(left, x), right = std::max(right, x);
      top = std::min(top, y), bottom = std::max(bottom, y);
    }
  }
  if (right < 0) return image;
  image.x = left, image.y = top, image.width = right - left + 1, image.height = bottom - top + 1;
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      for (int c = 0; c < channels; ++c) image.values.push_back(at(x, y, c) + 0.0f);  // no negative zero
    }
  }
  return image;
}

std::vector<float> expand_field_image(const FieldImage& image, int width, int height) {
  std::vector<float> values(static_cast<std::size_t>(width) * height * image.channels, 0.0f);
  const std::size_t row_length = static_cast<std::size_t>(image.width) * image.channels;
  for (int row = 0; row < image.height; ++row) {
    const std::size_t to = (static_cast<std::size_t>(image.y + row) * width + image.x) * image.channels;
    std::copy_n(image.values.begin() + static_cast<std::ptrdiff_t>(row * row_length), row_length,
                values.begin() + static_cast<std::ptrdiff_t>(to));
  }
  return values;
}

int find_control(const Deformation& deformation, const std::string& name) {
  for (std::size_t i = 0; i < deformation.controls.size(); ++i) {
    const RigControl& control = deformation.controls[i];
    if (control.name == name ||
        std::find(control.aliases.begin(), control.aliases.end(), name) != control.aliases.end())
      return static_cast<int>(i);
  }
  return -1;
}

std::string find_nearest_control(const Deformation& deformation, const std::string& name) {
  std::string nearest;
  std::size_t best = name.size() / 2 + 3;
  for (const RigControl& control : deformation.controls) {
    std::vector<std::string> names = control.aliases;
    names.insert(names.begin(), control.name);
    for (const std::string& known : names) {
      const std::size_t distance = edit_distance(name, known);
      if (distance < best) best = distance, nearest = control.name;
    }
  }
  return nearest;
}

}  // namespace phiz
