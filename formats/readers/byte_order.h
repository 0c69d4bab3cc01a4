#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace phiz::readers {

static_assert(std::endian::native == std::endian::little, "load() assumes a little-endian machine");

/// The number at `bytes`, which need not be aligned, stored little-endian or (kSwap) big-endian.
template <typename Number, bool kSwap = false>
Number load(const std::byte* bytes) {
  if constexpr (!kSwap || sizeof(Number) == 1) {
    Number value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
  } else {
    using Bits = std::conditional_t<sizeof(Number) == 2, std::uint16_t,
                                    std::conditional_t<sizeof(Number) == 4, std::uint32_t, std::uint64_t>>;
    Bits bits;
    std::memcpy(&bits, bytes, sizeof bits);
    if constexpr (sizeof bits == 2) bits = __builtin_bswap16(bits);
    if constexpr (sizeof bits == 4) bits = __builtin_bswap32(bits);
    if constexpr (sizeof bits == 8) bits = __builtin_bswap64(bits);
    return std::bit_cast<Number>(bits);
  }
}

}  // namespace phiz::readers
