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

/// A record's text without its notes, and the notes. They are most of the text, and a JSON parser would need
/// most of the time of a look at ten thousand subjects for them. They stand on a line of their own, as every
/// member does, and hold no quote and no escape but the line end's.
struct CutText {
  std::string rest, notes;
};

CutText cut_notes(std::string_view text) {
  constexpr std::string_view kBefore = "\n \"notes\": \"", kAfter = "\",\n", kLineEnd = "\\n";
  const std::size_t begin = text.find(kBefore);
  if (begin == std::string_view::npos) return {};
  std::string_view line = text.substr(begin + kBefore.size());
  const std::size_t length = line.find(kAfter);
  if (length == std::string_view::npos) return {};
  CutText cut;
  cut.rest = std::string(text.substr(0, begin + 1));
  cut.rest += line.substr(length + kAfter.size());
  line = line.substr(0, length);
  cut.notes.reserve(line.size());
  while (!line.empty()) {
    const std::size_t end = std::min(line.find(kLineEnd), line.size());
    cut.notes.append(line.substr(0, end)).push_back('\n');
    line.remove_prefix(std::min(end + kLineEnd.size(), line.size()));
  }
  return cut;
}

json parse_object(const std::string& text, const std::string& what) {
  json object = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!object.is_object()) throw StoreError(StoreFault::kDamaged, what + ": not a JSON object");
  return object;
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
  if (!notes.empty()) object["notes"] = notes;  // plain words and line ends: see cut_notes
  return seal_json(object);
}

SubjectRecord parse_subject(std::string_view text, const std::string& what) {
  const CutText cut = cut_notes(text);
  if (!cut.notes.empty() && !is_sealed_well(text)) unseal_json(text, what);  // says what is wrong
  const json object = cut.notes.empty() ? unseal_json(text, what) : parse_object(cut.rest, what);
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
    record.notes = parse_notes(cut.notes);
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
