#pragma once

#include <filesystem>
#include <string>

#include "store/digest.h"

namespace phiz {

/// Where everything lies in a store. Names are digests in hexadecimal or validated subject names, so no path
/// made here leaves the root.
struct StoreLayout {
  std::filesystem::path root;

  std::filesystem::path marker() const { return root / "phiz-store.json"; }
  std::filesystem::path objects() const { return root / "objects"; }
  std::filesystem::path object_folder(const Digest& digest) const {
    return objects() / digest.hex().substr(0, 2);
  }
  std::filesystem::path object(const Digest& digest) const {
    return object_folder(digest) / digest.hex().substr(2);
  }
  std::filesystem::path results() const { return root / "results"; }
  std::filesystem::path result(const Digest& key) const { return results() / (key.hex() + ".json"); }
  std::filesystem::path subjects() const { return root / "subjects"; }
  std::filesystem::path subject(const std::string& name) const { return subjects() / (name + ".json"); }
  std::filesystem::path checkpoints() const { return root / "checkpoints"; }
  std::filesystem::path checkpoint(const Digest& key) const { return checkpoints() / key.hex(); }
  std::filesystem::path leases() const { return root / "leases"; }
  std::filesystem::path lease(const Digest& key) const { return leases() / key.hex(); }
  std::filesystem::path pins() const { return root / "pins"; }
  std::filesystem::path logs() const { return root / "logs"; }
  std::filesystem::path damaged() const { return root / "damaged"; }
};

}  // namespace phiz
