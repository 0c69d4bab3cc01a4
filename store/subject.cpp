#include "store/subject.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "store/error.h"
#include "store/sealed_json.h"

namespace phiz {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxNameLength = 100;
constexpr std::size_t kMaxHistory = 64;

bool is_alphanumeric(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
}

bool is_name_character(char c) {
  return is_alphanumeric(c) || c == '.' || c == '_' || c == '-';
}

bool is_valid_name(std::string_view name) {
  return !name.empty() && name.size() <= kMaxNameLength && (is_alphanumeric(name[0]) || name[0] == '_') &&
         std::all_of(name.begin(), name.end(), is_name_character);
}

Digest parse_digest_or_throw(const json& value, const std::string& what) {
  const auto digest = parse_digest(value.get<std::string>());
  if (!digest) throw StoreError(StoreFault::kDamaged, what + ": a digest is no digest");
  return *digest;
}

}  // namespace

void SubjectRecord::set_current(const std::string& stage, const Digest& key) {
  const auto [entry, is_new] = results.try_emplace(stage, key);
  if (is_new || entry->second == key) return;
  history.push_back({stage, std::exchange(entry->second, key)});
  if (history.size() > kMaxHistory) history.erase(history.begin());
}

void SubjectRecord::set_current(const std::string& stage, ResultNote note) {
  set_current(stage, note.key);
  notes[stage] = std::move(note);
}

const ResultNote* SubjectRecord::find_note(const std::string& stage) const {
  const auto key = results.find(stage);
  const auto note = notes.find(stage);
  const bool is_current = key != results.end() && note != notes.end() && note->second.key == key->second;
  return is_current ? &note->second : nullptr;
}

std::string format_subject(const SubjectRecord& record) {
  json object;
  object["name"] = record.name;
  object["scan"] = {
      {"path", record.scan_path}, {"digest", record.scan_digest.hex()}, {"bytes", record.scan_bytes}};
  object["results"] = json::object();
  for (const auto& [stage, key] : record.results) object["results"][stage] = key.hex();
  object["history"] = json::array();
  for (const SubjectRecord::Past& past : record.history) {
    object["history"].push_back({{"stage", past.stage}, {"key", past.key.hex()}});
  }
  if (!record.scan_stamp.empty()) object["scan"]["stamp"] = record.scan_stamp;
  const std::string notes = format_notes(record.notes);
  if (!notes.empty()) object["notes"] = notes;
  return seal_json(object);
}

SubjectRecord parse_subject(std::string_view text, const std::string& what) {
  const json object = unseal_json(text, what);
  try {
    SubjectRecord record;
    record.name = object.at("name").get<std::string>();
    const json& scan = object.at("scan");
    record.scan_path = scan.at("path").get<std::string>();
    record.scan_digest = parse_digest_or_throw(scan.at("digest"), what);
    record.scan_bytes = scan.at("bytes").get<std::uint64_t>();
    for (const auto& [stage, key] : object.at("results").items()) {
      record.results[stage] = parse_digest_or_throw(key, what);
    }
    for (const json& past : object.at("history")) {
      record.history.push_back(
          {past.at("stage").get<std::string>(), parse_digest_or_throw(past.at("key"), what)});
    }
    if (const auto stamp = scan.find("stamp"); stamp != scan.end())
      record.scan_stamp = stamp->get<std::string>();
    if (const auto notes = object.find("notes"); notes != object.end()) {
      record.notes = parse_notes(notes->get_ref<const std::string&>());
    }
    return record;
  } catch (const json::exception& error) {
    throw StoreError(StoreFault::kDamaged, what + ": " + error.what());
  }
}

void validate_subject_name(const std::string& name) {
  if (is_valid_name(name)) return;
  std::string shown = name.substr(0, 40);
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  throw StoreError(StoreFault::kInvalidName, "not a name for a subject: '" + shown + "'",
                   "use 1 to 100 letters, digits, '.', '_' or '-', not beginning with '.' or '-'");
}

std::string make_subject_name(std::string_view stem) {
  if (is_valid_name(stem)) return std::string(stem);
  std::string name(stem.substr(0, 80));
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !is_name_character(c); }, '_');
  const char* prefix = name.empty() || !is_alphanumeric(name[0]) ? "_" : "";
  return prefix + name + "-" + compute_digest(stem).hex().substr(0, 8);
}

}  // namespace phiz
