#include "store/lease.h"

#include <chrono>
#include <nlohmann/json.hpp>

#include "store/error.h"
#include "store/sealed_json.h"

namespace phiz {
namespace {

constexpr std::uint64_t kMaxLeaseBytes = 1 << 16;

struct LeaseText {
  ProcessIdentity owner;
  std::string host;
};

/// Nothing if the text is no whole lease (its writer died in the middle, or it is foreign).
std::optional<LeaseText> parse_lease(const std::string& text) {
  try {
    const nlohmann::json object = unseal_json(text, "lease");
    LeaseText lease;
    lease.owner.place = object.at("place").get<std::string>();
    lease.owner.pid = object.at("pid").get<std::int64_t>();
    lease.owner.start = object.at("start").get<std::uint64_t>();
    lease.host = object.at("host").get<std::string>();
    return lease;
  } catch (const StoreError&) {
    return std::nullopt;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

std::span<const std::byte> as_bytes(const std::string& text) {
  return std::as_bytes(std::span(text));
}

/// The file's text; nothing if it has gone.
std::optional<std::string> read_if_there(FileSystem& files, const std::filesystem::path& path) {
  try {
    return files.read_file(path, kMaxLeaseBytes);
  } catch (const StoreError& error) {
    if (error.fault() == StoreFault::kMissing) return std::nullopt;
    throw;
  }
}

}  // namespace

Lease::~Lease() {
  if (table_ != nullptr) table_->release(key_);
}

LeaseTable::LeaseTable(const Store& store, Processes& processes, LeaseOptions options)
    : store_(store), processes_(processes), options_(options), self_(processes.self()) {}

LeaseTable::~LeaseTable() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  if (heartbeat_.joinable()) heartbeat_.join();
}

std::string LeaseTable::format(std::uint64_t beat) const {
  return seal_json({{"place", self_.place},
                    {"host", host_name()},
                    {"pid", self_.pid},
                    {"start", self_.start},
                    {"beat", beat}});
}

bool LeaseTable::is_dead(const Digest& key, const std::string& text) {
  const auto lease = parse_lease(text);
  if (lease && lease->owner.place == self_.place && !processes_.is_alive(lease->owner)) return true;
  const double now = processes_.now_seconds();
  Observation& observation = observed_[key];
  if (observation.text != text) observation = {text, now};
  return now - observation.first_seen_seconds >= options_.dead_after_seconds;
}

std::variant<Lease, LeaseHolder> LeaseTable::try_acquire(const Digest& key) {
  const std::lock_guard lock(mutex_);
  if (held_.contains(key)) return LeaseHolder{host_name(), self_.pid};
  FileSystem& files = store_.files();
  const std::filesystem::path path = store_.layout().lease(key);
  // Each turn either takes the lease, finds a living holder, or removes a dead one's file.
  for (int turn = 0; turn < 3; ++turn) {
    if (files.create_exclusively(path, as_bytes(format(0)))) {
      held_[key] = 0;
      observed_.erase(key);
      if (!heartbeat_.joinable()) heartbeat_ = std::thread([this] { run_heartbeat(); });
      return Lease(*this, key);
    }
    const auto text = read_if_there(files, path);
    if (!text) continue;
    if (!is_dead(key, *text)) {
      const auto lease = parse_lease(*text);
      return lease ? LeaseHolder{lease->host, lease->owner.pid} : LeaseHolder{"unknown", 0};
    }
    files.remove_file(path);
  }
  return LeaseHolder{"unknown", 0};  // others were quicker each time
}

void LeaseTable::release(const Digest& key) noexcept {
  const std::lock_guard lock(mutex_);
  held_.erase(key);
  try {
    const std::filesystem::path path = store_.layout().lease(key);
    const auto text = read_if_there(store_.files(), path);
    const auto lease = text ? parse_lease(*text) : std::nullopt;
    if (lease && lease->owner == self_) store_.files().remove_file(path);
  } catch (const std::exception&) {
    // The lease stays behind; others find it dead as soon as this process is gone.
  }
}

bool LeaseTable::is_held(const Digest& key) {
  const std::lock_guard lock(mutex_);
  if (held_.contains(key)) return true;
  const auto text = read_if_there(store_.files(), store_.layout().lease(key));
  return text && !is_dead(key, *text);
}

std::vector<LeaseTable::Entry> LeaseTable::list() {
  const std::lock_guard lock(mutex_);
  std::vector<Entry> entries;
  for (const std::string& name : store_.files().list_folder(store_.layout().leases())) {
    const auto key = parse_digest(name);
    if (!key) continue;
    const auto text = read_if_there(store_.files(), store_.layout().lease(*key));
    if (!text) continue;
    const auto lease = parse_lease(*text);
    const LeaseHolder holder = lease ? LeaseHolder{lease->host, lease->owner.pid} : LeaseHolder{"unknown", 0};
    entries.push_back({*key, holder, is_dead(*key, *text)});
  }
  return entries;
}

bool LeaseTable::break_lease(const Digest& key) {
  return store_.files().remove_file(store_.layout().lease(key));
}

void LeaseTable::renew() {
  const std::lock_guard lock(mutex_);
  for (auto& [key, beat] : held_) {
    const std::filesystem::path path = store_.layout().lease(key);
    const std::filesystem::path temporary = path.parent_path() / (".tmp-" + make_unique_name());
    try {
      store_.files().create_file(temporary, as_bytes(format(++beat)), FileSystem::Mode::kWritable);
      store_.files().rename(temporary, path);
    } catch (const std::exception&) {
      // A heartbeat that could not be written costs at most a takeover, which ends well.
    }
  }
}

void LeaseTable::run_heartbeat() {
  std::unique_lock lock(mutex_);
  const auto period = std::chrono::duration<double>(options_.heartbeat_seconds);
  while (!wake_.wait_for(lock, period, [this] { return stopping_; })) {
    lock.unlock();
    renew();
    lock.lock();
  }
}

}  // namespace phiz
