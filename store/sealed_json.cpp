#include "store/sealed_json.h"

#include <nlohmann/json.hpp>

#include "store/digest.h"
#include "store/error.h"

namespace phiz {
namespace {

constexpr std::string_view kBeforeSeal = ",\n \"seal\": \"";
constexpr std::string_view kAfterSeal = "\"\n}\n";
constexpr std::size_t kHexDigits = 64;
constexpr std::size_t kTail = kBeforeSeal.size() + kHexDigits + kAfterSeal.size();

}  // namespace

std::string seal_json(const nlohmann::json& object) {
  std::string text = object.dump(1, ' ', false, nlohmann::json::error_handler_t::replace);
  text.resize(text.size() - 2);  // "\n}"
  const std::string seal = compute_digest(text).hex();
  return text.append(kBeforeSeal).append(seal).append(kAfterSeal);
}

nlohmann::json unseal_json(std::string_view text, const std::string& what) {
  if (text.size() < kTail || !text.ends_with(kAfterSeal)) {
    throw StoreError(StoreFault::kDamaged, what + ": cut short, its seal is missing");
  }
  if (!is_sealed_well(text)) {
    throw StoreError(StoreFault::kDamaged, what + ": its bytes do not match its seal");
  }
  nlohmann::json object = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!object.is_object()) throw StoreError(StoreFault::kDamaged, what + ": not a JSON object");
  object.erase("seal");
  return object;
}

std::optional<Digest> read_seal(std::string_view text) {
  if (text.size() < kTail) return std::nullopt;
  const std::string_view tail = text.substr(text.size() - kTail);
  if (!tail.starts_with(kBeforeSeal) || !tail.ends_with(kAfterSeal)) return std::nullopt;
  return parse_digest(tail.substr(kBeforeSeal.size(), kHexDigits));
}

std::optional<std::string> mend_one_bit(std::string text) {
  constexpr std::size_t kMaxBytes = 1 << 20;
  if (is_sealed_well(text)) return text;
  if (text.size() > kMaxBytes) return std::nullopt;
  for (std::size_t bit = 0; bit < 8 * text.size(); ++bit) {
    const char mask = static_cast<char>(1 << bit % 8);
    text[bit / 8] ^= mask;
    if (is_sealed_well(text)) return text;
    text[bit / 8] ^= mask;
  }
  return std::nullopt;
}

bool is_sealed_well(std::string_view text) {
  const auto seal = read_seal(text);
  return seal && compute_digest(text.substr(0, text.size() - kTail)) == *seal;
}

}  // namespace phiz
