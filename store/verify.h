#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "store/store.h"

namespace phiz {

/// One file of the store that is not as it was written, or is missing.
struct StoreDamage {
  std::string
      what;  ///< "object <digest>", "result <key>", "subject <name>", "checkpoint <key>", "lease <key>"
  std::string cause;
  std::vector<std::string> used_by;    ///< "<stage> <key> <output>" of results that name it
  std::filesystem::path set_aside_to;  ///< empty if there was nothing to move
};

struct VerifyReport {
  std::uint64_t objects = 0, results = 0, subjects = 0, checkpoints = 0, bytes = 0;  ///< looked at
  std::vector<StoreDamage> damages;
  bool ok() const { return damages.empty(); }
};

/// Reads every byte of the store: objects against their names, results and subjects against their seals and
/// their names, outputs of results against what is there. Damaged files are set aside, so that the next run
/// computes them anew; nothing is deleted. Other processes may work in the store meanwhile. O(bytes in the
/// store). `progress` gets the bytes read so far.
VerifyReport verify_store(const Store& store, const std::function<void(std::uint64_t bytes)>& progress = {});

/// Puts back results and subjects' records that were set aside, now or earlier, because one bit had flipped:
/// the seal says which. Those that have been written anew since are left. How many it did. Throws StoreError.
std::size_t restore_flipped_bits(const Store& store);

}  // namespace phiz
