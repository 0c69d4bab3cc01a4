#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "store/lease.h"
#include "store/store.h"

namespace phiz {

struct CollectOptions {
  bool is_dry_run = false;
  /// Only what has been there, unchanged, for so long by the store's own clock is removed.
  double older_than_seconds = 14 * 86400;
  /// If set: no more than is needed to come down to this size, the oldest first.
  std::optional<std::uint64_t> max_bytes;
};

struct CollectReport {
  struct Item {
    std::string what;  ///< "object <digest>", "result <key>", "checkpoint <key>", "temporary <path>",
                       ///< "damaged <name>"
    std::uint64_t bytes = 0;
    double age_seconds = 0;
  };
  std::vector<Item> removed;  ///< or what would be removed; sorted by what
  std::uint64_t bytes_before = 0, bytes_removed = 0;
  std::uint64_t restored = 0;  ///< things that came to be needed while we worked, and were put back
};

/// Removes what nobody needs: results that are current for no subject and not pinned, objects that neither a
/// kept result made nor was made from, leftovers of dead processes. Others may work in the store meanwhile:
/// whatever comes to be needed is first named (by a result or a record) and then looked for, and nothing is
/// deleted before it has been moved away and all names have been read once more. So what is needed is either
/// named in time and put back, or missed in time and written anew by whoever needs it.
/// Throws kDamaged if a subject's record cannot be read (it is not known what it needs: verify first),
/// kLeaseHeld if another process is collecting. O(names in the store); reads every record and every current
/// result.
CollectReport collect_garbage(const Store& store, LeaseTable& leases, const CollectOptions& options,
                              const std::function<void()>& check_stop = {});

}  // namespace phiz
