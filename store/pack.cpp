#include "store/pack.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

#include "store/error.h"
#include "store/sealed_json.h"

namespace phiz {
namespace {

constexpr std::size_t kBlock = 512;
constexpr std::size_t kNameBytes = 100, kSizeAt = 124, kSizeDigits = 11, kSumAt = 148, kSumBytes = 8,
                      kTypeAt = 156;

// Members of a tar -----------------------------------------------------------------------------------------

std::size_t padded(std::size_t bytes) {
  return (bytes + kBlock - 1) / kBlock * kBlock;
}

unsigned sum_of(std::string_view header) {
  unsigned sum = 0;
  for (std::size_t i = 0; i < kBlock; ++i) {
    const bool is_sum = i >= kSumAt && i < kSumAt + kSumBytes;
    sum += is_sum ? ' ' : static_cast<unsigned char>(header[i]);
  }
  return sum;
}

void add_member(std::string& archive, const std::string& name, std::string_view bytes) {
  std::string header(kBlock, '\0');
  const auto put = [&](std::size_t at, const std::string& text) { header.replace(at, text.size(), text); };
  put(0, name);
  put(100, "0000444");
  put(108, "0000000");
  put(116, "0000000");
  put(kSizeAt, fmt::format("{:011o}", bytes.size()));
  put(136, "00000000000");
  put(kTypeAt, "0");
  put(257, std::string("ustar\0", 6) + "00");
  put(kSumAt, fmt::format("{:06o}", sum_of(header)) + std::string("\0 ", 2));
  archive += header;
  archive += bytes;
  archive.resize(padded(archive.size()));
}

struct Member {
  std::string name;
  std::string_view bytes;
};

[[noreturn]] void fail(const std::string& what) {
  throw StoreError(StoreFault::kDamaged, "the pack: " + what);
}

std::uint64_t parse_octal(std::string_view digits) {
  std::uint64_t value = 0;
  for (const char c : digits) {
    if (c < '0' || c > '7') fail("a length is not one");
    value = 8 * value + static_cast<std::uint64_t>(c - '0');
  }
  return value;
}

std::vector<Member> split(std::string_view archive) {
  std::vector<Member> members;
  std::size_t at = 0;
  for (;;) {
    if (archive.size() - at < kBlock) fail("cut short");
    const std::string_view header = archive.substr(at, kBlock);
    if (header.find_first_not_of('\0') == std::string_view::npos) return members;
    at += kBlock;
    if (parse_octal(header.substr(kSumAt, 6)) != sum_of(header)) fail("a header's sum is wrong");
    if (header[kTypeAt] != '0') fail("a member that is no plain file");
    const std::uint64_t size = parse_octal(header.substr(kSizeAt, kSizeDigits));
    if (size > archive.size() - at || padded(size) > archive.size() - at) fail("cut short");
    const std::string_view name = header.substr(0, kNameBytes);
    members.push_back({std::string(name.substr(0, name.find('\0'))), archive.substr(at, size)});
    at += padded(size);
  }
}

// What a pack holds ----------------------------------------------------------------------------------------

const std::string kMarker = "phiz-pack.json";

std::string marker_text() {
  return seal_json({{"format_version", 1}, {"created_by", "phiz"}});
}

std::optional<Digest> object_named(const std::string& name) {
  if (name.size() != 8 + 2 + 1 + 62 || !name.starts_with("objects/") || name[10] != '/') return std::nullopt;
  return parse_digest(name.substr(8, 2) + name.substr(11));
}

std::optional<Digest> result_named(const std::string& name) {
  if (!name.starts_with("results/") || !name.ends_with(".json") || name.size() < 13) return std::nullopt;
  return parse_digest(name.substr(8, name.size() - 13));
}

bool is_subject_name(const std::string& name) {
  return name.starts_with("subjects/") && name.ends_with(".json") &&
         std::all_of(name.begin() + 9, name.end() - 5, [](char c) { return c >= '0' && c <= '9'; });
}

/// Everything checked, nothing written.
struct Contents {
  std::vector<std::string_view> objects;
  std::vector<Result> results;
  std::vector<SubjectRecord> subjects;
};

Contents check(std::string_view archive) {
  const std::vector<Member> members = split(archive);
  if (members.empty() || members.front().name != kMarker || members.front().bytes != marker_text()) {
    fail("not a pack of this format version");
  }
  Contents contents;
  std::set<std::string> names;
  for (const Member& member : members) {
    if (!names.insert(member.name).second) fail("two members of one name");
    if (member.name == kMarker) continue;
    if (const auto object = object_named(member.name)) {
      if (compute_digest(member.bytes) != *object) fail(member.name + " has other bytes than its name says");
      contents.objects.push_back(member.bytes);
    } else if (const auto key = result_named(member.name)) {
      contents.results.push_back(parse_result(member.bytes, "the pack: " + member.name));
      if (contents.results.back().key() != *key) fail(member.name + " is the result of another key");
    } else if (is_subject_name(member.name)) {
      contents.subjects.push_back(parse_subject(member.bytes, "the pack: " + member.name));
      validate_subject_name(contents.subjects.back().name);
    } else {
      fail("a member that belongs in no store");
    }
  }
  return contents;
}

void require_outputs(const Store& store, const Contents& contents) {
  std::set<Digest> packed;
  for (const std::string_view bytes : contents.objects) packed.insert(compute_digest(bytes));
  for (const Result& result : contents.results) {
    for (const auto& [name, output] : result.outputs) {
      const bool is_there = packed.contains(output.digest) || store.find_object_size(output.digest);
      if (!is_there) fail("result " + result.key().hex() + " without its output " + name);
    }
  }
}

/// What a current result needs, into the archive, each once.
void add_result(const Store& store, const Digest& key, std::set<std::string>& added, std::string& archive) {
  const std::string name = "results/" + key.hex() + ".json";
  if (!added.insert(name).second) return;
  const auto result = store.find_done_result(key);
  if (!result)
    throw StoreError(StoreFault::kMissing, "result " + key.hex() + " is not whole", "run phiz fit again");
  const auto add_object = [&](const Digest& digest) {
    const std::string hex = digest.hex(), object = "objects/" + hex.substr(0, 2) + "/" + hex.substr(2);
    if (added.insert(object).second) add_member(archive, object, store.read_object(digest));
  };
  for (const auto& [output, object] : result->outputs) add_object(object.digest);
  for (const KeyText::Entry& entry : result->key_text.entries()) {
    const auto digest = entry.tag == "input" ? parse_digest(entry.value) : std::nullopt;
    if (digest && store.find_object_size(*digest)) add_object(*digest);
  }
  add_member(archive, name, store.files().read_file(store.layout().result(key)));
}

}  // namespace

std::string pack_subjects(const Store& store, const std::vector<std::string>& names) {
  std::string archive, records;
  add_member(archive, kMarker, marker_text());
  std::set<std::string> added;
  int number = 0;
  for (const std::string& name : std::set<std::string>(names.begin(), names.end())) {
    const auto record = store.find_subject(name);
    if (!record) throw StoreError(StoreFault::kMissing, "the store has no subject '" + name + "'");
    SubjectRecord packed = *record;
    packed.history.clear();  // of results that stay behind
    packed.scan_stamp.clear();
    for (const auto& [stage, key] : packed.results) add_result(store, key, added, archive);
    add_member(records, fmt::format("subjects/{:06}.json", ++number), format_subject(packed));
  }
  archive += records;
  return archive.append(2 * kBlock, '\0');
}

UnpackReport unpack_subjects(const Store& store, std::string_view archive, const UnpackOptions& options) {
  const Contents contents = check(archive);
  require_outputs(store, contents);
  UnpackReport report;
  for (const SubjectRecord& record : contents.subjects) {
    const auto there = store.find_subject(record.name);
    const bool differs =
        there && (there->results != record.results || there->scan_digest != record.scan_digest);
    if (differs && !options.replaces_subjects) {
      throw StoreError(StoreFault::kExists, "the store has another subject '" + record.name + "'",
                       "replace it with --replace, or unpack into another --store");
    }
  }
  for (const std::string_view bytes : contents.objects) {
    DurableWriter writer(store.files());
    store.put_object(writer, bytes);
    writer.publish();
    ++report.objects;
  }
  for (const Result& result : contents.results) {
    store.put_result(result);
    ++report.results;
  }
  for (const SubjectRecord& record : contents.subjects) {
    const auto there = store.find_subject(record.name);
    if (!there || there->results != record.results) store.save_subject(record);
    report.subjects.push_back(record.name);
  }
  return report;
}

}  // namespace phiz
