#include "store/pack.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "store/error.h"
#include "store/sealed_json.h"
#include "store/tar.h"

namespace phiz {
namespace {

const std::string kMarker = "phiz-pack.json";
constexpr std::uint64_t kMaxJsonBytes = 16 << 20;

[[noreturn]] void fail(const std::string& what) {
  throw StoreError(StoreFault::kDamaged, "the pack: " + what);
}

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
  return name.starts_with("subjects/") && name.ends_with(".json") && name.size() >= 14 &&
         std::all_of(name.begin() + 9, name.end() - 5, [](char c) { return c >= '0' && c <= '9'; });
}

/// Writes the members, each once.
class Packer {
 public:
  Packer(const Store& store, const WritePack& write) : store_(store), write_(write) {}

  void pack(const std::vector<std::string>& names) {
    add_member(kMarker, marker_text());
    std::vector<SubjectRecord> records;
    for (const std::string& name : std::set<std::string>(names.begin(), names.end())) {
      auto record = store_.find_subject(name);
      if (!record) throw StoreError(StoreFault::kMissing, "the store has no subject '" + name + "'");
      record->history.clear();  // of results that stay behind
      record->scan_stamp.clear();
      for (const auto& [stage, key] : record->results) add_result(key);
      records.push_back(std::move(*record));
    }
    int number = 0;
    for (const SubjectRecord& record : records)
      add_member(fmt::format("subjects/{:06}.json", ++number), format_subject(record));
    write_(std::string(2 * kTarBlock, '\0'));
  }

 private:
  void add_member(const std::string& name, std::string_view bytes) const {
    write_(make_tar_header(name, bytes.size()));
    write_(bytes);
    write_(std::string(tar_padding(bytes.size()), '\0'));
  }

  void add_object(const Digest& digest) {
    const std::string hex = digest.hex(), name = "objects/" + hex.substr(0, 2) + "/" + hex.substr(2);
    if (added_.insert(name).second) add_member(name, store_.read_object(digest));
  }

  /// What a current result needs, then the result.
  void add_result(const Digest& key) {
    const std::string name = "results/" + key.hex() + ".json";
    if (!added_.insert(name).second) return;
    const auto result = store_.find_done_result(key);
    if (!result) {
      throw StoreError(StoreFault::kMissing, "result " + key.hex() + " is not whole", "run phiz fit again");
    }
    for (const auto& [output, object] : result->outputs) add_object(object.digest);
    for (const KeyText::Entry& entry : result->key_text.entries()) {
      const auto digest = entry.tag == "input" ? parse_digest(entry.value) : std::nullopt;
      if (digest && store_.find_object_size(*digest)) add_object(*digest);
    }
    add_member(name, store_.files().read_file(store_.layout().result(key)));
  }

  const Store& store_;
  const WritePack& write_;
  std::set<std::string> added_;
};

/// A pack that is whole and well, without its objects.
struct Contents {
  std::set<Digest> objects;
  std::vector<Result> results;
  std::vector<SubjectRecord> subjects;
};

/// Looks at every byte and writes nothing: objects are hashed as they come.
class Checker {
 public:
  Contents check(const ReadPack& read) {
    TarReader reader({[this](const std::string& name, std::uint64_t size) { begin(name, size); },
                      [this](std::string_view bytes) { take(bytes); }, [this] { end(); }});
    read([&](std::string_view bytes) { reader.feed(bytes); });
    reader.finish();
    if (names_.empty()) fail("not a pack of this format version");
    return std::move(contents_);
  }

 private:
  void begin(const std::string& name, std::uint64_t size) {
    if (names_.empty() && name != kMarker) fail("not a pack of this format version");
    if (!names_.insert(name).second) fail("two members of one name");
    name_ = name;
    object_ = object_named(name);
    const bool is_known = object_ || name == kMarker || result_named(name) || is_subject_name(name);
    if (!is_known) fail("a member that belongs in no store");
    if (!object_ && size > kMaxJsonBytes) fail(name + " is too long");
    hash_.emplace();
    text_.clear();
  }

  void take(std::string_view bytes) {
    if (object_) {
      hash_->update(bytes);
    } else {
      text_ += bytes;
    }
  }

  void end() {
    if (object_) {
      if (hash_->finish() != *object_) fail(name_ + " has other bytes than its name says");
      contents_.objects.insert(*object_);
    } else if (name_ == kMarker) {
      if (text_ != marker_text()) fail("not a pack of this format version");
    } else if (const auto key = result_named(name_)) {
      contents_.results.push_back(parse_result(text_, "the pack: " + name_));
      if (contents_.results.back().key() != *key) fail(name_ + " is the result of another key");
    } else {
      contents_.subjects.push_back(parse_subject(text_, "the pack: " + name_));
      validate_subject_name(contents_.subjects.back().name);
    }
  }

  Contents contents_;
  std::set<std::string> names_;
  std::string name_, text_;
  std::optional<Digest> object_;
  std::optional<Sha256> hash_;
};

void require_outputs(const Store& store, const Contents& contents) {
  for (const Result& result : contents.results) {
    for (const auto& [name, output] : result.outputs) {
      const bool is_there = contents.objects.contains(output.digest) || store.find_object_size(output.digest);
      if (!is_there) fail("result " + result.key().hex() + " without its output " + name);
    }
  }
}

void require_subjects(const Store& store, const Contents& contents, const UnpackOptions& options) {
  if (options.replaces_subjects) return;
  for (const SubjectRecord& record : contents.subjects) {
    const auto there = store.find_subject(record.name);
    if (there && (there->results != record.results || there->scan_digest != record.scan_digest)) {
      throw StoreError(StoreFault::kExists, "the store has another subject '" + record.name + "'",
                       "replace it with --replace, or unpack into another --store");
    }
  }
}

/// The second reading: one object after the other goes into the store.
std::uint64_t put_objects(const Store& store, const ReadPack& read) {
  std::optional<Digest> object;
  std::string bytes;
  std::uint64_t count = 0;
  TarReader reader({[&](const std::string& name, std::uint64_t) {
                      object = object_named(name);
                      bytes.clear();
                    },
                    [&](std::string_view block) {
                      if (object) bytes += block;
                    },
                    [&] {
                      if (!object) return;
                      DurableWriter writer(store.files());
                      if (store.put_object(writer, bytes).digest != *object)
                        fail("it changed while it was read");
                      writer.publish();
                      ++count;
                    }});
  read([&](std::string_view block) { reader.feed(block); });
  return count;
}

}  // namespace

void pack_subjects(const Store& store, const std::vector<std::string>& names, const WritePack& write) {
  Packer(store, write).pack(names);
}

std::string pack_subjects(const Store& store, const std::vector<std::string>& names) {
  std::string archive;
  pack_subjects(store, names, [&](std::string_view bytes) { archive += bytes; });
  return archive;
}

std::uint64_t pack_to_file(const Store& store, const std::vector<std::string>& names,
                           const std::filesystem::path& file, const std::function<void()>& check_stop) {
  FileSystem& files = store.files();
  const std::filesystem::path unfinished = file.parent_path() / (".tmp-" + make_unique_name());
  std::uint64_t size = 0;
  try {
    files.create_file(unfinished, {}, FileSystem::Mode::kWritable);
    pack_subjects(store, names, [&](std::string_view bytes) {
      files.append(unfinished, std::as_bytes(std::span(bytes)));
      size += bytes.size();
      if (check_stop) check_stop();
    });
    files.sync_file(unfinished);
    files.rename(unfinished, file);
  } catch (...) {
    try {
      files.remove_file(unfinished);
    } catch (const StoreError&) {
      // What went wrong before is what the caller must hear.
    }
    throw;
  }
  files.sync_folder(file.parent_path());
  return size;
}

UnpackReport unpack_subjects(const Store& store, const ReadPack& read, const UnpackOptions& options) {
  const Contents contents = Checker().check(read);
  require_outputs(store, contents);
  require_subjects(store, contents, options);
  UnpackReport report;
  report.objects = put_objects(store, read);
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

UnpackReport unpack_subjects(const Store& store, std::string_view archive, const UnpackOptions& options) {
  return unpack_subjects(
      store, [&](const auto& take) { take(archive); }, options);
}

UnpackReport unpack_file(const Store& store, const std::filesystem::path& file,
                         const UnpackOptions& options) {
  const ReadPack read = [&](const auto& take) {
    store.files().read_blocks(file, [&](std::span<const std::byte> block) {
      take({reinterpret_cast<const char*>(block.data()), block.size()});
    });
  };
  return unpack_subjects(store, read, options);
}

}  // namespace phiz
