#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace phiz {

/// A SHA-256 digest. Its text form is 64 lower-case hexadecimal digits.
struct Digest {
  std::array<std::uint8_t, 32> bytes{};

  std::string hex() const;
  auto operator<=>(const Digest&) const = default;
};

/// Exactly 64 lower-case hexadecimal digits, else nothing.
std::optional<Digest> parse_digest(std::string_view hex);

/// Incremental SHA-256. One use: update..., then finish once.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void update(std::span<const std::byte> bytes);
  void update(std::string_view text) { update(std::as_bytes(std::span(text))); }
  Digest finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

Digest compute_digest(std::span<const std::byte> bytes);
inline Digest compute_digest(std::string_view text) {
  return compute_digest(std::as_bytes(std::span(text)));
}

}  // namespace phiz
