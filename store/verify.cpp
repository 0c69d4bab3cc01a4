#include "store/verify.h"

#include <functional>
#include <map>
#include <optional>

#include "store/checkpoint.h"
#include "store/error.h"
#include "store/run_log.h"
#include "store/sealed_json.h"

namespace phiz {
namespace {

constexpr std::uint64_t kMaxJsonBytes = 16 << 20;
constexpr std::uint64_t kMaxLogBytes = std::uint64_t{1} << 30;

class Verifier {
 public:
  Verifier(const Store& store, const std::function<void(std::uint64_t)>& progress)
      : store_(store), progress_(progress) {}

  VerifyReport run() {
    for (const Digest& key : store_.list_results()) check_result(key);
    for (const Digest& digest : store_.list_objects()) check_object(digest);
    for (const std::string& name : store_.list_subjects()) check_subject(name);
    check_checkpoints();
    check_leases();
    check_logs();
    check_outputs();
    return std::move(report_);
  }

 private:
  struct Use {
    std::string result;
    OutputObject output;
  };

  void add_bytes(std::uint64_t bytes) {
    report_.bytes += bytes;
    if (progress_) progress_(report_.bytes);
  }

  StoreDamage& add_damage(std::string what, std::string cause, const std::filesystem::path& file) {
    StoreDamage damage{std::move(what), std::move(cause), {}, {}};
    if (!file.empty()) damage.set_aside_to = store_.set_aside(file);
    return report_.damages.emplace_back(std::move(damage));
  }

  /// What `look` finds wrong with a file, if anything. What cannot be read is read once more: an error that
  /// comes again is damage, one that does not was the disk's or the net's. Faults that are not the file's own
  /// are thrown.
  static std::optional<std::string> find_cause(const std::function<std::optional<std::string>()>& look) {
    for (bool is_second = false;; is_second = true) {
      try {
        return look();
      } catch (const StoreError& error) {
        if (error.fault() == StoreFault::kMissing) return std::nullopt;  // removed meanwhile
        const bool is_damage =
            error.fault() == StoreFault::kDamaged || (error.fault() == StoreFault::kIo && is_second);
        if (is_damage) return error.what();
        if (error.fault() != StoreFault::kIo) throw;
      }
    }
  }

  void check_result(const Digest& key) {
    const auto path = store_.layout().result(key);
    ++report_.results;
    const auto cause = find_cause([&]() -> std::optional<std::string> {
      const std::string text = store_.files().read_file(path, kMaxJsonBytes);
      const Result result = parse_result(text, path.string());
      if (result.key() != key) return "its key text has another key";
      add_bytes(text.size());
      for (const auto& [name, output] : result.outputs)
        uses_[output.digest].push_back({result.stage() + " " + key.hex() + " " + name, output});
      return std::nullopt;
    });
    if (cause) add_damage("result " + key.hex(), *cause, path);
  }

  void check_object(const Digest& digest) {
    const auto path = store_.layout().object(digest);
    ++report_.objects;
    const auto cause = find_cause([&]() -> std::optional<std::string> {
      Sha256 hash;
      store_.files().read_blocks(path, [&](std::span<const std::byte> block) {
        hash.update(block);
        add_bytes(block.size());
      });
      if (hash.finish() != digest) return "its bytes are not what was written";
      return std::nullopt;
    });
    if (!cause) return;
    StoreDamage& damage = add_damage("object " + digest.hex(), *cause, path);
    for (const Use& use : uses_[digest]) damage.used_by.push_back(use.result);
  }

  void check_subject(const std::string& name) {
    ++report_.subjects;
    const auto path = store_.layout().subjects() / (name + ".json");
    const auto cause = find_cause([&]() -> std::optional<std::string> {
      try {
        const auto record = store_.find_subject(name);
        if (record && record->name != name) return "it is the record of another subject";
      } catch (const StoreError& error) {
        if (error.fault() != StoreFault::kInvalidName) throw;
        return error.what();
      }
      return std::nullopt;
    });
    if (cause) add_damage("subject " + name, *cause, path);
  }

  void check_checkpoints() {
    FileSystem& files = store_.files();
    for (const std::string& name : files.list_folder(store_.layout().checkpoints())) {
      const auto key = parse_digest(name);
      if (!key) continue;
      const auto path = store_.layout().checkpoint(*key) / "state";
      const auto cause = find_cause([&]() -> std::optional<std::string> {
        const std::string text = files.read_file(path);
        ++report_.checkpoints;
        add_bytes(text.size());
        if (!is_whole_checkpoint(text)) return "its bytes are not what was written";
        return std::nullopt;
      });
      if (cause) add_damage("checkpoint " + name, *cause, path);
    }
  }

  void check_leases() {
    FileSystem& files = store_.files();
    for (const std::string& name : files.list_folder(store_.layout().leases())) {
      if (!parse_digest(name)) continue;
      const auto path = store_.layout().leases() / name;
      try {
        const std::string text = files.read_file(path, kMaxJsonBytes);
        add_bytes(text.size());
        if (is_sealed_well(text)) continue;
        if (mend_one_bit(text)) {
          add_damage("lease " + name, "its bytes do not match its seal", path);
        } else {
          files.remove_file(path);  // torn by a power cut: leases are not synced, and their holder is gone
        }
      } catch (const StoreError& error) {
        if (error.fault() != StoreFault::kMissing) throw;
      }
    }
  }

  void check_logs() {
    FileSystem& files = store_.files();
    const auto folder = store_.layout().logs();
    if (!files.find_status(folder)) return;
    for (const std::string& name : files.list_folder(folder)) {
      try {
        const std::string text = files.read_file(folder / name, kMaxLogBytes);
        add_bytes(text.size());
        std::string cause;
        const std::size_t line = name.ends_with(".log") ? find_damaged_line(text) : 0;
        if (line != 0) cause = "line " + std::to_string(line) + " is not as it was written";
        const bool is_torn = name.ends_with(".json") && !is_temporary_name(name) && !is_sealed_well(text);
        if (is_torn || !is_as_its_name_says(name, text)) cause = "its bytes are not what was written";
        if (!cause.empty()) add_damage("log " + name, cause, folder / name);
      } catch (const StoreError& error) {
        if (error.fault() != StoreFault::kMissing) throw;
      }
    }
  }

  void check_outputs() {
    for (const auto& [digest, uses] : uses_) {
      const auto size = store_.find_object_size(digest);
      for (const Use& use : uses) {
        if (size == use.output.size_bytes || was_set_aside(digest)) continue;
        StoreDamage& damage =
            add_damage("object " + digest.hex(), size ? "it has another length" : "it is missing", {});
        damage.used_by.push_back(use.result);
      }
    }
  }

  bool was_set_aside(const Digest& digest) const {
    for (const StoreDamage& damage : report_.damages) {
      if (damage.what == "object " + digest.hex()) return true;
    }
    return false;
  }

  const Store& store_;
  const std::function<void(std::uint64_t)>& progress_;
  VerifyReport report_;
  std::map<Digest, std::vector<Use>> uses_;
};

}  // namespace

std::size_t restore_flipped_bits(const Store& store) {
  FileSystem& files = store.files();
  const std::filesystem::path damaged = store.layout().damaged();
  if (!files.find_status(damaged)) return 0;
  std::size_t restored = 0;
  for (const std::string& name : files.list_folder(damaged)) {  // "results-<key>.json.<unique>"
    const std::size_t dash = name.find('-'), end = name.rfind(".json.");
    if (dash == std::string::npos || end == std::string::npos || end < dash) continue;
    const std::string folder = name.substr(0, dash), stem = name.substr(dash + 1, end - dash - 1);
    if (folder != "results" && folder != "subjects") continue;
    const std::filesystem::path place = store.layout().root / folder / (stem + ".json");
    if (files.find_status(place)) continue;
    const auto text = mend_one_bit(files.read_file(damaged / name, kMaxJsonBytes));
    if (!text) continue;
    DurableWriter writer(files);
    writer.add(place, std::as_bytes(std::span(*text)), FileSystem::Mode::kWritable);
    writer.publish();
    ++restored;
  }
  return restored;
}

VerifyReport verify_store(const Store& store, const std::function<void(std::uint64_t)>& progress) {
  return Verifier(store, progress).run();
}

}  // namespace phiz
