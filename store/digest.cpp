#include "store/digest.h"

#include <openssl/evp.h>

#include <algorithm>

#include "store/error.h"

namespace phiz {
namespace {

constexpr char kHexDigits[] = "0123456789abcdef";

void check(int openssl_result) {
  if (openssl_result != 1) throw StoreError(StoreFault::kIo, "SHA-256 is not available from OpenSSL");
}

constexpr std::array<std::int8_t, 256> make_hex_values() {
  std::array<std::int8_t, 256> values{};
  values.fill(-1);
  for (std::int8_t value = 0; value < 16; ++value) {
    values[static_cast<unsigned char>(kHexDigits[value])] = value;
  }
  return values;
}
constexpr auto kHexValues = make_hex_values();

}  // namespace

std::string Digest::hex() const {
  std::string text(2 * bytes.size(), '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    text[2 * i] = kHexDigits[bytes[i] >> 4];
    text[2 * i + 1] = kHexDigits[bytes[i] & 15];
  }
  return text;
}

std::optional<Digest> parse_digest(std::string_view hex) {
  Digest digest;
  if (hex.size() != 2 * digest.bytes.size()) return std::nullopt;
  int seen = 0;  // negative once a character was no digit
  for (std::size_t i = 0; i < digest.bytes.size(); ++i) {
    const int high = kHexValues[static_cast<unsigned char>(hex[2 * i])];
    const int low = kHexValues[static_cast<unsigned char>(hex[2 * i + 1])];
    seen |= high | low;
    digest.bytes[i] = static_cast<std::uint8_t>(16 * (high & 15) + (low & 15));
  }
  if (seen < 0) return std::nullopt;
  return digest;
}

struct Sha256::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
  ~State() { EVP_MD_CTX_free(context); }
};

Sha256::Sha256() : state_(std::make_unique<State>()) {
  check(state_->context != nullptr && EVP_DigestInit_ex(state_->context, EVP_sha256(), nullptr));
}

Sha256::~Sha256() = default;

void Sha256::update(std::span<const std::byte> bytes) {
  check(EVP_DigestUpdate(state_->context, bytes.data(), bytes.size()));
}

Digest Sha256::finish() {
  Digest digest;
  unsigned int length = 0;
  check(EVP_DigestFinal_ex(state_->context, digest.bytes.data(), &length));
  return digest;
}

Digest compute_digest(std::span<const std::byte> bytes) {
  Sha256 hash;
  hash.update(bytes);
  return hash.finish();
}

}  // namespace phiz
