#include <nlohmann/json.hpp>

#include "formats/control_mesh_parts.h"
#include "formats/error.h"
#include "formats/text.h"

namespace phiz::control_mesh_parts {
namespace {

using Json = nlohmann::json;

constexpr int kDecimals = 6;
constexpr const char* kSchema = "phiz.control_mesh.1";

// ---- reading: every function gets the path of the value for its errors

/// The members of an object that must have exactly these keys.
void check_keys(const Json& value, std::initializer_list<const char*> keys, const std::string& path) {
  const std::string place = path.empty() ? "" : " (" + path + ")";
  if (!value.is_object()) throw FormatError("is not an object" + place);
  for (const char* key : keys) {
    if (!value.contains(key)) throw FormatError("missing key '" + std::string(key) + "'" + place);
  }
  for (const auto& [key, member] : value.items()) {
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
      throw FormatError("unknown key '" + key + "'" + place);
    }
  }
}

double parse_double(const Json& value, const std::string& path) {
  if (!value.is_number()) throw FormatError("is not a number (" + path + ")");
  return value.get<double>();
}

int parse_int(const Json& value, const std::string& path) {
  if (!value.is_number_integer()) throw FormatError("is not an integer (" + path + ")");
  const auto wide = value.get<std::int64_t>();
  if (wide < 0 || wide > std::numeric_limits<int>::max()) throw FormatError("is no index (" + path + ")");
  return static_cast<int>(wide);
}

const Json& check_array(const Json& value, const std::string& path) {
  if (!value.is_array()) throw FormatError("is not a list (" + path + ")");
  return value;
}

std::vector<int> parse_ints(const Json& value, const std::string& path) {
  std::vector<int> numbers;
  for (const Json& element : check_array(value, path)) {
    numbers.push_back(parse_int(element, path + "[" + std::to_string(numbers.size()) + "]"));
  }
  return numbers;
}

Eigen::Vector3d parse_vector(const Json& value, const std::string& path) {
  if (check_array(value, path).size() != 3) throw FormatError("does not have three numbers (" + path + ")");
  return {parse_double(value[0], path + "[0]"), parse_double(value[1], path + "[1]"),
          parse_double(value[2], path + "[2]")};
}

template <typename Value>
std::map<std::string, Value> parse_named(const Json& root, const char* key,
                                         Value (*parse)(const Json&, const std::string&)) {
  const Json& value = root[key];
  if (!value.is_object()) throw FormatError("is not an object (" + std::string(key) + ")");
  std::map<std::string, Value> named;
  for (const auto& [name, member] : value.items()) named[name] = parse(member, key + ("." + name));
  return named;
}

Eigen::AlignedBox3d parse_box(const Json& value, const std::string& path) {
  check_keys(value, {"max", "min"}, path);
  return {parse_vector(value["min"], path + ".min"), parse_vector(value["max"], path + ".max")};
}

SurfacePoint parse_point(const Json& value, const std::string& path) {
  check_keys(value, {"triangle", "weights"}, path);
  return {parse_int(value["triangle"], path + ".triangle"),
          parse_vector(value["weights"], path + ".weights")};
}

Plane parse_plane(const Json& value, const std::string& path) {
  check_keys(value, {"normal", "offset_mm"}, path);
  return {parse_vector(value["normal"], path + ".normal"),
          parse_double(value["offset_mm"], path + ".offset_mm")};
}

std::vector<std::pair<int, int>> parse_edges(const Json& value, const std::string& path) {
  std::vector<std::pair<int, int>> edges;
  for (const Json& element : check_array(value, path)) {
    const std::string place = path + "[" + std::to_string(edges.size()) + "]";
    const std::vector<int> ends = parse_ints(element, place);
    if (ends.size() != 2) throw FormatError("is not a pair of vertices (" + place + ")");
    edges.emplace_back(ends[0], ends[1]);
  }
  return edges;
}

Json parse_text(const std::string& text) {
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    throw FormatError("is not JSON (byte " + std::to_string(error.byte) + ")");
  } catch (const Json::exception&) {
    throw FormatError("is not JSON with numbers in range");
  }
}

// ---- writing: one line for each name, lists on one line, keys sorted

std::string text_of(double value) {
  std::string text;
  append_fixed(text, value, kDecimals, true);
  return text;
}
std::string text_of(int value) {
  return std::to_string(value);
}
std::string text_of(const std::pair<int, int>& edge) {
  return std::string("[").append(text_of(edge.first)).append(", ").append(text_of(edge.second)).append("]");
}

template <typename List>
std::string text_of_list(const List& list) {
  std::string text = "[";
  for (const auto& element : list) text += (text.size() > 1 ? ", " : "") + text_of(element);
  return text + "]";
}

std::string text_of(const std::vector<int>& list) {
  return text_of_list(list);
}
std::string text_of(const Eigen::AlignedBox3d& box) {
  return "{\"max\": " + text_of_list(box.max()) + ", \"min\": " + text_of_list(box.min()) + "}";
}
std::string text_of(const SurfacePoint& point) {
  return "{\"triangle\": " + text_of(point.triangle_idx) + ", \"weights\": " + text_of_list(point.weights) +
         "}";
}
std::string text_of(const Plane& plane) {
  return "{\"normal\": " + text_of_list(plane.normal) + ", \"offset_mm\": " + text_of(plane.offset_mm) + "}";
}

template <typename Value>
std::string text_of_named(const std::map<std::string, Value>& named) {
  std::string text = "{";
  for (const auto& [name, value] : named) {
    text += (text.size() > 1 ? ",\n    \"" : "\n    \"") + name + "\": " + text_of(value);
  }
  return text + (named.empty() ? "}" : "\n  }");
}

}  // namespace

Annotations parse_json(const std::string& text) {
  const Json root = parse_text(text);
  check_keys(root,
             {"binding_edges", "boxes", "clipping_planes", "constrained_vertices", "landmarks", "mirror",
              "regions", "schema"},
             "");
  if (root["schema"] != kSchema) throw FormatError("is not \"" + std::string(kSchema) + "\" (schema)");
  Annotations annotations;
  annotations.boxes = parse_named(root, "boxes", parse_box);
  annotations.landmarks = parse_named(root, "landmarks", parse_point);
  annotations.regions = parse_named(root, "regions", parse_ints);
  annotations.binding_edges = parse_edges(root["binding_edges"], "binding_edges");
  annotations.constrained_vertices = parse_ints(root["constrained_vertices"], "constrained_vertices");
  annotations.clipping_planes = parse_named(root, "clipping_planes", parse_plane);
  annotations.mirror = parse_ints(root["mirror"], "mirror");
  return annotations;
}

std::string format_json(const Annotations& annotations) {
  std::string text = "{\n";
  text += "  \"binding_edges\": " + text_of_list(annotations.binding_edges) + ",\n";
  text += "  \"boxes\": " + text_of_named(annotations.boxes) + ",\n";
  text += "  \"clipping_planes\": " + text_of_named(annotations.clipping_planes) + ",\n";
  text += "  \"constrained_vertices\": " + text_of_list(annotations.constrained_vertices) + ",\n";
  text += "  \"landmarks\": " + text_of_named(annotations.landmarks) + ",\n";
  text += "  \"mirror\": " + text_of_list(annotations.mirror) + ",\n";
  text += "  \"regions\": " + text_of_named(annotations.regions) + ",\n";
  text += "  \"schema\": \"" + std::string(kSchema) + "\"\n}\n";
  return text;
}

}  // namespace phiz::control_mesh_parts
