#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace phiz {

/// JSON files of the store carry a seal: their last member is the SHA-256 of every byte before it, so that
/// any flipped bit is found. Grammar: the object's own text, `,\n "seal": "` 64 hex digits `"\n}\n`.
std::string seal_json(const nlohmann::json& object);

/// The object without its seal. Throws StoreError kDamaged ("<what>: …") if a byte is not as it was written.
nlohmann::json unseal_json(std::string_view text, const std::string& what);

}  // namespace phiz
