#pragma once

#include <optional>
#include <span>
#include <string>

#include "store/digest.h"
#include "store/store.h"

namespace phiz {

/// The latest saved state of one computation that is under way, named by the key of the result it will
/// become. Atomic and durable: load() gives the last state that was saved whole, however the process ended.
///
/// File `checkpoints/<key>/state`: "phiz-checkpoint 1 " 64 hex digits of the SHA-256 of the rest LF, then the
/// bytes.
class Checkpoint {
 public:
  Checkpoint(const Store& store, const Digest& key) : store_(&store), key_(key) {}

  void save(std::span<const std::byte> bytes) const;  ///< replaces what was saved before; throws StoreError
  std::optional<std::string> load() const;  ///< nothing if none, or if it is damaged (it is then dropped)
  void remove() const;                      ///< when the result is done

 private:
  std::filesystem::path file() const { return store_->layout().checkpoint(key_) / "state"; }

  const Store* store_;
  Digest key_;
};

/// True if the text of such a file is as it was written.
bool is_whole_checkpoint(const std::string& text);

}  // namespace phiz
