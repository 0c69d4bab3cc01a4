#include "store/collect.h"

#include <algorithm>
#include <set>

#include "store/error.h"

namespace phiz {
namespace {

namespace fs = std::filesystem;

constexpr double kCheckpointSeconds = 7 * 86400;  // of work that was not continued
constexpr double kLogSeconds = 90 * 86400;
constexpr double kDamagedSeconds = 30 * 86400;  // of files that were found damaged

/// What must stay.
struct Needed {
  std::set<Digest> results, objects;
};

/// A file that may go.
struct Candidate {
  fs::path path;
  CollectReport::Item item;
};

class Collector {
 public:
  Collector(const Store& store, LeaseTable& leases, const CollectOptions& options,
            const std::function<void()>& check_stop)
      : store_(store), files_(store.files()), leases_(leases), options_(options), check_stop_(check_stop) {}

  CollectReport run() {
    auto lease = leases_.try_acquire(compute_digest("phiz store gc"));
    if (const auto* holder = std::get_if<LeaseHolder>(&lease)) {
      throw StoreError(StoreFault::kLeaseHeld, "process " + std::to_string(holder->pid) + " on " +
                                                   holder->host + " is collecting now");
    }
    now_ = read_clock();
    if (!options_.is_dry_run) restore_trash(mark());  // of a collector that was killed
    const Needed needed = mark();
    find_candidates(needed);
    choose();
    if (!options_.is_dry_run) remove();
    for (Candidate& candidate : candidates_) {
      report_.bytes_removed += candidate.item.bytes;
      report_.removed.push_back(std::move(candidate.item));
    }
    std::sort(report_.removed.begin(), report_.removed.end(),
              [](const auto& a, const auto& b) { return a.what < b.what; });
    return std::move(report_);
  }

 private:
  void check_stop() const {
    if (check_stop_) check_stop_();
  }

  fs::path trash() const { return store_.layout().root / "trash"; }

  /// Now by the clock that gives our files their times, which may be another machine's.
  double read_clock() {
    const fs::path probe = store_.layout().root / (".tmp-" + make_unique_name());
    files_.create_file(probe, {}, FileSystem::Mode::kWritable);
    const auto now = files_.find_change_time_seconds(probe);
    files_.remove_file(probe);
    if (!now) throw StoreError(StoreFault::kIo, store_.layout().root.string() + ": the disk tells no times");
    return *now;
  }

  double age_of(const fs::path& path) const {
    const auto time = files_.find_change_time_seconds(path);
    return time ? now_ - *time : 0;
  }

  void need(const std::map<std::string, OutputObject>& outputs, Needed& needed) const {
    for (const auto& [name, output] : outputs) needed.objects.insert(output.digest);
  }

  void need_result(const Digest& key, Needed& needed) const {
    if (!needed.results.insert(key).second) return;
    const auto result = store_.find_result(key);
    if (!result) return;
    need(result->outputs, needed);
    for (const KeyText::Entry& entry : result->key_text.entries()) {
      const auto digest = entry.tag == "input" ? parse_digest(entry.value) : std::nullopt;
      if (digest) needed.objects.insert(*digest);
    }
  }

  Needed mark() const {
    Needed needed;
    for (const std::string& name : store_.list_subjects()) {
      check_stop();
      std::optional<SubjectRecord> record;
      try {
        record = store_.find_subject(name);
      } catch (const StoreError& error) {
        throw StoreError(StoreFault::kDamaged, error.what(),
                         "run phiz store verify and phiz fit first: it is not known what this subject needs");
      }
      if (!record) continue;
      for (const auto& [stage, key] : record->results) need_result(key, needed);
      for (const auto& [stage, note] : record->notes) need(note.outputs, needed);
    }
    for (const Digest& key : store_.list_pins()) need_result(key, needed);
    // Results that stay only because they are young: their outputs stay with them.
    for (const Digest& key : store_.list_results()) {
      if (age_of(store_.layout().result(key)) < options_.older_than_seconds) need_result(key, needed);
    }
    return needed;
  }

  /// Counts the file, and keeps it in mind if it may go.
  void look_at(const fs::path& path, const std::string& what, bool may_go, double least_age) {
    const auto status = files_.find_status(path);
    if (!status || status->kind != FileSystem::Kind::kFile) return;
    report_.bytes_before += status->size_bytes;
    if (!may_go) return;
    const double age = age_of(path);
    if (age >= least_age) candidates_.push_back({path, {what, status->size_bytes, age}});
  }

  void look_at_folder(const fs::path& folder, const std::string& what, bool only_temporary,
                      double least_age) {
    if (!files_.find_status(folder)) return;
    for (const std::string& name : files_.list_folder(folder)) {
      if (only_temporary && !is_temporary_name(name)) continue;
      look_at(folder / name, what + " " + (folder.filename() / name).string(), true, least_age);
    }
  }

  void find_candidates(const Needed& needed) {
    const StoreLayout& layout = store_.layout();
    const double age = options_.older_than_seconds;
    for (const Digest& key : store_.list_results()) {
      look_at(layout.result(key), "result " + key.hex(), !needed.results.contains(key), age);
    }
    for (const Digest& digest : store_.list_objects()) {
      check_stop();
      look_at(layout.object(digest), "object " + digest.hex(), !needed.objects.contains(digest), age);
    }
    for (const fs::path& folder : {layout.results(), layout.subjects(), layout.leases(), layout.root}) {
      look_at_folder(folder, "temporary", true, std::max(age, 3600.0));
    }
    for (const std::string& name : files_.list_folder(layout.objects())) {
      if (name.size() == 2) look_at_folder(layout.objects() / name, "temporary", true, std::max(age, 3600.0));
    }
    look_at_folder(layout.logs(), "log", false, std::max(age, kLogSeconds));
    look_at_folder(layout.damaged(), "damaged", false, std::max(age, kDamagedSeconds));
    for (const std::string& name : files_.list_folder(layout.checkpoints())) find_checkpoint(name, needed);
  }

  void find_checkpoint(const std::string& name, const Needed& needed) {
    const auto key = parse_digest(name);
    if (!key) return;
    const bool is_finished = needed.results.contains(*key) && store_.find_done_result(*key);
    const fs::path folder = store_.layout().checkpoint(*key);
    for (const std::string& file : files_.list_folder(folder)) {
      look_at(folder / file, "checkpoint " + name + "/" + file, !leases_.is_held(*key),
              is_finished ? options_.older_than_seconds
                          : std::max(options_.older_than_seconds, kCheckpointSeconds));
    }
  }

  /// With a size to come down to, only as many as that takes, the oldest first.
  void choose() {
    if (!options_.max_bytes) return;
    std::stable_sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
      return a.item.age_seconds > b.item.age_seconds;
    });
    std::uint64_t left = report_.bytes_before;
    std::size_t count = 0;
    while (count < candidates_.size() && left > *options_.max_bytes) left -= candidates_[count++].item.bytes;
    candidates_.resize(count);
  }

  void remove() {
    for (const char* part : {"results", "objects"}) files_.make_folders(trash() / part);
    for (const Candidate& candidate : candidates_) {
      check_stop();
      const std::string& what = candidate.item.what;
      const bool is_named = what.starts_with("result ") || what.starts_with("object ");
      if (!is_named) {
        files_.remove_file(candidate.path);
        if (what.starts_with("checkpoint ")) files_.remove_folder(candidate.path.parent_path());
        continue;
      }
      try {
        const std::string part = what.starts_with("result ") ? "results" : "objects";
        files_.rename(candidate.path, trash() / part / what.substr(7));
      } catch (const StoreError& error) {
        if (error.fault() != StoreFault::kMissing) throw;
      }
    }
    restore_trash(mark());
    for (const char* part : {"results", "objects"}) {
      for (const std::string& name : files_.list_folder(trash() / part))
        files_.remove_file(trash() / part / name);
      files_.remove_folder(trash() / part);
    }
    files_.remove_folder(trash());
  }

  /// Puts back what is needed, unless it has been written anew meanwhile.
  void restore_trash(const Needed& needed) {
    if (!files_.find_status(trash())) return;
    restore(trash() / "results", needed, true);
    // A result that came back needs its outputs again.
    restore(trash() / "objects", report_.restored > 0 ? mark() : needed, false);
  }

  void restore(const fs::path& folder, const Needed& needed, bool is_result) {
    if (!files_.find_status(folder)) return;
    for (const std::string& name : files_.list_folder(folder)) {
      const auto digest = parse_digest(name);
      if (!digest || !(is_result ? needed.results : needed.objects).contains(*digest)) continue;
      const fs::path place = is_result ? store_.layout().result(*digest) : store_.layout().object(*digest);
      if (files_.find_status(place)) continue;
      files_.rename(folder / name, place);
      files_.sync_folder(place.parent_path());
      ++report_.restored;
      const std::string what = (is_result ? "result " : "object ") + name;
      std::erase_if(candidates_, [&](const Candidate& candidate) { return candidate.item.what == what; });
    }
  }

  const Store& store_;
  FileSystem& files_;
  LeaseTable& leases_;
  const CollectOptions options_;
  const std::function<void()>& check_stop_;
  double now_ = 0;
  std::vector<Candidate> candidates_;
  CollectReport report_;
};

}  // namespace

CollectReport collect_garbage(const Store& store, LeaseTable& leases, const CollectOptions& options,
                              const std::function<void()>& check_stop) {
  return Collector(store, leases, options, check_stop).run();
}

}  // namespace phiz
