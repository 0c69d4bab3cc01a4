#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "store/process.h"
#include "store/store.h"

namespace phiz {

struct LeaseOptions {
  double heartbeat_seconds = 5;    ///< how often a held lease is renewed
  double dead_after_seconds = 30;  ///< a lease that did not change for so long is dead
};

class LeaseTable;

/// The right to compute one key, given back by the destructor. It saves work, it does not guard truth: two
/// processes that compute the same key both end well (same bytes), so losing a lease is never an error.
class Lease {
 public:
  Lease(Lease&& other) noexcept : table_(std::exchange(other.table_, nullptr)), key_(other.key_) {}
  Lease& operator=(Lease&&) = delete;
  ~Lease();

 private:
  friend class LeaseTable;
  Lease(LeaseTable& table, const Digest& key) : table_(&table), key_(key) {}
  LeaseTable* table_;
  Digest key_;
};

/// Who holds a lease that could not be had.
struct LeaseHolder {
  std::string host;
  std::int64_t pid = 0;
};

/// The leases of one process in one store, renewed by a thread of its own while any is held.
///
/// A holder is dead if it ran on this machine and its process is gone (asked of the kernel, with the start
/// time, so a reused pid does not count), or, wherever it runs, if its lease file did not change for
/// `dead_after_seconds` by our own monotonic clock. No clock is compared with another machine's, no
/// modification time is read. A dead lease is taken over.
class LeaseTable {
 public:
  LeaseTable(const Store& store, Processes& processes, LeaseOptions options = {});
  ~LeaseTable();
  LeaseTable(const LeaseTable&) = delete;
  LeaseTable& operator=(const LeaseTable&) = delete;

  /// The lease, or who has it. Never waits. Throws StoreError. A key this table holds already is held by us:
  /// a second thread is told our own pid.
  std::variant<Lease, LeaseHolder> try_acquire(const Digest& key);

  /// True if a living process, ours or another, computes the key now.
  bool is_held(const Digest& key);

  /// Every lease there is.
  struct Entry {
    Digest key;
    LeaseHolder holder;
    bool is_dead = false;
  };
  std::vector<Entry> list();

  /// Removes a lease whoever holds it; false if there was none. Safe at any time: two that compute one key
  /// both end well.
  bool break_lease(const Digest& key);

  /// Renews every held lease once; called by the thread, and by tests.
  void renew();

 private:
  friend class Lease;
  struct Observation {
    std::string text;
    double first_seen_seconds = 0;
  };
  void release(const Digest& key) noexcept;
  std::string format(std::uint64_t beat) const;
  bool is_dead(const Digest& key, const std::string& text);
  void run_heartbeat();

  const Store& store_;
  Processes& processes_;
  const LeaseOptions options_;
  const ProcessIdentity self_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::map<Digest, std::uint64_t> held_;  // key -> beats so far
  std::map<Digest, Observation> observed_;
  bool stopping_ = false;
  std::thread heartbeat_;
};

}  // namespace phiz
