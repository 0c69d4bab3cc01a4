#include "store/result.h"

#include <nlohmann/json.hpp>

#include "store/error.h"
#include "store/sealed_json.h"

namespace phiz {
namespace {

using nlohmann::json;

json entries_with_tag(const KeyText& key_text, const std::string& tag) {
  json object = json::object();
  for (const KeyText::Entry& entry : key_text.entries()) {
    if (entry.tag == tag) object[entry.name] = entry.value;
  }
  return object;
}

[[noreturn]] void throw_damaged(const std::string& what, const std::string& cause) {
  throw StoreError(StoreFault::kDamaged, what + ": " + cause);
}

OutputObject parse_output(const json& value, const std::string& what) {
  const auto digest = parse_digest(value.at("digest").get<std::string>());
  if (!digest) throw_damaged(what, "an output's digest is no digest");
  return {*digest, value.at("bytes").get<std::uint64_t>()};
}

}  // namespace

std::string Result::stage() const {
  for (const KeyText::Entry& entry : key_text.entries()) {
    if (entry.tag == "stage") return entry.value;
  }
  return {};
}

std::string format_result(const Result& result) {
  json object;
  object["stage"] = result.stage();
  const json version = entries_with_tag(result.key_text, "version");
  object["version"] = version.empty() ? "" : version.begin().value();
  object["parameters"] = entries_with_tag(result.key_text, "parameter");
  object["inputs"] = entries_with_tag(result.key_text, "input");
  object["key_text"] = result.key_text.text();
  object["outputs"] = json::object();
  for (const auto& [name, output] : result.outputs) {
    object["outputs"][name] = {{"digest", output.digest.hex()}, {"bytes", output.size_bytes}};
  }
  object["run"] = {{"seconds", result.run.seconds},
                   {"peak_memory_bytes", result.run.peak_memory_bytes},
                   {"host", result.run.host},
                   {"tool_version", result.run.tool_version},
                   {"reason", result.run.reason}};
  return seal_json(object);
}

Result parse_result(std::string_view text, const std::string& what) {
  const json object = unseal_json(text, what);
  try {
    Result result;
    result.seal = read_seal(text).value();
    auto key_text = parse_key_text(object.at("key_text").get<std::string>());
    if (!key_text) throw_damaged(what, "its key text is not one");
    result.key_text = std::move(*key_text);
    for (const auto& [name, value] : object.at("outputs").items()) {
      result.outputs[name] = parse_output(value, what);
    }
    const json& run = object.at("run");
    result.run.seconds = run.at("seconds").get<double>();
    result.run.peak_memory_bytes = run.at("peak_memory_bytes").get<std::uint64_t>();
    result.run.host = run.at("host").get<std::string>();
    result.run.tool_version = run.at("tool_version").get<std::string>();
    result.run.reason = run.at("reason").get<std::string>();
    return result;
  } catch (const json::exception& error) {
    throw_damaged(what, error.what());
  }
}

}  // namespace phiz
