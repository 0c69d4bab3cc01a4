#include "formats/glb_chunks.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "formats/error.h"

namespace phiz {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF numbers are written as they lie in memory");

constexpr std::uint32_t kMagic = 0x46546c67, kVersion = 2, kJson = 0x4e4f534a, kBin = 0x004e4942;
constexpr std::size_t kHeaderBytes = 12, kChunkHeaderBytes = 8;

std::size_t padded(std::size_t length) {
  return (length + 3) / 4 * 4;
}

void append_word(std::string& bytes, std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  bytes.append(reinterpret_cast<const char*>(&word), 4);
}

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, 4);
  return word;
}

std::string_view take_chunk(std::string_view bytes, std::size_t& at, std::uint32_t kind) {
  const std::string place = " (byte " + std::to_string(at) + ")";
  if (bytes.size() - at < kChunkHeaderBytes) throw FormatError("glb ends early" + place);
  const std::size_t length = word_at(bytes, at);
  if (word_at(bytes, at + 4) != kind) throw FormatError("glb chunk is of another kind" + place);
  at += kChunkHeaderBytes;
  if (length > bytes.size() - at) throw FormatError("glb chunk is longer than the file" + place);
  at += length;
  return bytes.substr(at - length, length);
}

}  // namespace

std::string join_glb(std::string_view json, std::string_view bin) {
  const std::size_t total = kHeaderBytes + 2 * kChunkHeaderBytes + padded(json.size()) + padded(bin.size());
  if (total > std::numeric_limits<std::uint32_t>::max()) throw FormatError("glb would be above 4 GiB");
  std::string bytes;
  bytes.reserve(total);
  for (std::size_t word : {std::size_t{kMagic}, std::size_t{kVersion}, total}) append_word(bytes, word);
  append_word(bytes, padded(json.size()));
  append_word(bytes, kJson);
  bytes.append(json).append(padded(json.size()) - json.size(), ' ');
  append_word(bytes, padded(bin.size()));
  append_word(bytes, kBin);
  bytes.append(bin).append(padded(bin.size()) - bin.size(), '\0');
  return bytes;
}

GlbChunks split_glb(std::string_view bytes) {
  if (bytes.size() < kHeaderBytes || word_at(bytes, 0) != kMagic) throw FormatError("is not a glb (byte 0)");
  if (word_at(bytes, 4) != kVersion) throw FormatError("is not glTF 2 (byte 4)");
  if (word_at(bytes, 8) != bytes.size()) {
    throw FormatError("is " + std::to_string(bytes.size()) + " bytes long, not " +
                      std::to_string(word_at(bytes, 8)) + " (byte 8)");
  }
  std::size_t at = kHeaderBytes;
  GlbChunks chunks;
  chunks.json = take_chunk(bytes, at, kJson);
  if (at < bytes.size()) chunks.bin = take_chunk(bytes, at, kBin);
  return chunks;
}

}  // namespace phiz
