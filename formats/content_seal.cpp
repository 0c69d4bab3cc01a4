#include "formats/content_seal.h"

#include <openssl/evp.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>

#include "formats/error.h"

namespace phiz {
namespace {

constexpr std::uint32_t kNewestVdbVersion = 224;  // of OpenVDB 10
constexpr std::string_view kVdbMagic{" BDV\0\0\0\0", 8};
constexpr std::size_t kUuidOffset = 21;
constexpr std::size_t kUuidLength = 36;
constexpr std::string_view kUuidMark = "7068697a-";

std::string uuid_of(std::string_view bytes) {
  const std::string digest = digest_without(bytes, kUuidOffset, kUuidLength);
  std::string uuid(kUuidMark);
  uuid.append(digest, 0, 4).append("-8").append(digest, 4, 3).append("-a").append(digest, 7, 3);
  return uuid.append("-").append(digest, 10, 12);
}

}  // namespace

std::string digest_without(std::string_view bytes, std::size_t offset, std::size_t length) {
  const std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> hash(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  const std::string blank(length, '0');
  const std::string_view tail = bytes.substr(offset + length);
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  unsigned int digest_bytes = 0;
  const bool done = hash && EVP_DigestInit_ex(hash.get(), EVP_sha256(), nullptr) == 1 &&
                    EVP_DigestUpdate(hash.get(), bytes.data(), offset) == 1 &&
                    EVP_DigestUpdate(hash.get(), blank.data(), blank.size()) == 1 &&
                    EVP_DigestUpdate(hash.get(), tail.data(), tail.size()) == 1 &&
                    EVP_DigestFinal_ex(hash.get(), digest.data(), &digest_bytes) == 1;
  if (!done) throw FormatError("SHA-256 could not be computed");
  std::string hex;
  for (unsigned int i = 0; i < digest_bytes; ++i) {
    constexpr const char* kDigits = "0123456789abcdef";
    (hex += kDigits[digest[i] >> 4]) += kDigits[digest[i] & 15];
  }
  return hex;
}

void seal_vdb(std::string& bytes) {
  bytes.replace(kUuidOffset, kUuidLength, uuid_of(bytes));
}

void check_vdb_seal(std::string_view bytes) {
  if (!bytes.starts_with(kVdbMagic) || bytes.size() < kUuidOffset + kUuidLength) {
    throw FormatError("is not an OpenVDB file (byte 0)");
  }
  // OpenVDB would print a warning of its own on stdout, which is for results.
  std::uint32_t version = 0;
  std::memcpy(&version, bytes.data() + 8, sizeof version);
  if (version > kNewestVdbVersion) {
    throw FormatError("is an OpenVDB file of version " + std::to_string(version) + ", the newest known is " +
                      std::to_string(kNewestVdbVersion) + " (byte 8)");
  }
  const std::string_view uuid = bytes.substr(kUuidOffset, kUuidLength);
  if (uuid.starts_with(kUuidMark) && uuid != uuid_of(bytes)) {
    throw FormatError("is damaged: its content does not match its seal (byte 21)");
  }
}

}  // namespace phiz
