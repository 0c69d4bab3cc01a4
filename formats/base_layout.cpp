#include "formats/base_layout.h"

#include <istream>
#include <map>
#include <nlohmann/json.hpp>

#include "formats/error.h"

namespace phiz {
namespace {

using Json = nlohmann::json;

constexpr const char* kSchema = "phiz.base_layout.1";
constexpr std::size_t kMostPoints = 100'000;

const Json& member(const Json& object, const char* key, const std::string& place) {
  if (!object.is_object()) throw FormatError("is not an object (" + place + ")");
  const auto found = object.find(key);
  if (found == object.end()) throw FormatError("missing key '" + std::string(key) + "' (" + place + ")");
  return *found;
}

void refuse_others(const Json& object, std::initializer_list<const char*> known, const std::string& place) {
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw FormatError("unknown key '" + key + "' (" + place + ")");
  }
}

double coordinate(const Json& value, const std::string& place) {
  if (!value.is_number()) throw FormatError("is no number (" + place + ")");
  const auto number = value.get<double>();
  if (!(number >= 0 && number <= 1)) throw FormatError("is not from 0 to 1 (" + place + ")");
  return number;
}

const Json& list(const Json& document, const char* key) {
  const Json& value = member(document, key, "document");
  if (!value.is_array()) throw FormatError("is no list (" + std::string(key) + ")");
  if (value.size() > kMostPoints) throw FormatError("has too many entries (" + std::string(key) + ")");
  return value;
}

}  // namespace

BaseLayout read_base_layout(std::istream& in) {
  const std::string text(std::istreambuf_iterator<char>(in), {});
  const Json document = Json::parse(text, nullptr, false);
  if (document.is_discarded()) throw FormatError("is not JSON");
  const Json& schema = member(document, "schema", "document");
  if (schema != kSchema) throw FormatError("the schema is not " + std::string(kSchema));
  refuse_others(document, {"schema", "points", "edges"}, "document");
  BaseLayout layout;
  std::map<std::string, int> indices;
  for (const Json& point : list(document, "points")) {
    const std::string place = "points " + std::to_string(layout.uv.size());
    const Json &name = member(point, "name", place), &uv = member(point, "uv", place);
    refuse_others(point, {"name", "uv"}, place);
    if (!name.is_string() || name.get<std::string>().empty())
      throw FormatError("the name is no text (" + place + ")");
    if (!uv.is_array() || uv.size() != 2) throw FormatError("uv is not two numbers (" + place + ")");
    if (!indices.emplace(name.get<std::string>(), static_cast<int>(layout.uv.size())).second)
      throw FormatError("the name " + name.get<std::string>() + " is there twice (" + place + ")");
    layout.names.push_back(name.get<std::string>());
    layout.uv.emplace_back(coordinate(uv[0], place), coordinate(uv[1], place));
  }
  for (const Json& edge : list(document, "edges")) {
    const std::string place = "edges " + std::to_string(layout.edges.size());
    if (!edge.is_array() || edge.size() != 2 || !edge[0].is_string() || !edge[1].is_string())
      throw FormatError("is not two names (" + place + ")");
    const auto a = indices.find(edge[0].get<std::string>()), b = indices.find(edge[1].get<std::string>());
    if (a == indices.end() || b == indices.end() || a == b)
      throw FormatError("does not name two points (" + place + ")");
    layout.edges.emplace_back(a->second, b->second);
  }
  return layout;
}

}  // namespace phiz
