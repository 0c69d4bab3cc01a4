#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <istream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/text.h"

namespace phiz::json_members {

/// What readers of designed JSON files share (.cpp files only): members taken by key and type, unknown ones
/// refused, the place named in every FormatError.

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

inline Json parse_root(std::istream& in, const char* schema) {
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

}  // namespace phiz::json_members
