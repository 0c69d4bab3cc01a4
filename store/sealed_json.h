#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "store/digest.h"

namespace phiz {

/// JSON files of the store carry a seal: their last member is the SHA-256 of every byte before it, so that
/// any flipped bit is found. Grammar: the object's own text, `,\n "seal": "` 64 hex digits `"\n}\n`.
std::string seal_json(const nlohmann::json& object);

/// The object without its seal. Throws StoreError kDamaged ("<what>: …") if a byte is not as it was written.
nlohmann::json unseal_json(std::string_view text, const std::string& what);

/// The seal that the text carries, whether or not the rest matches it; nothing if it carries none.
std::optional<Digest> read_seal(std::string_view text);

/// True if every byte is as it was when the text was sealed. O(bytes), parses nothing.
bool is_sealed_well(std::string_view text);

/// The text as it was sealed, if no more than one of its bits has flipped since: each is tried. Nothing for
/// texts above 1 MB. O(bytes^2), 0.1 s for 4 kB.
std::optional<std::string> mend_one_bit(std::string text);

}  // namespace phiz
