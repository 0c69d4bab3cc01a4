#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "formats/error.h"
#include "tests/support/random.h"

namespace phiz::test {

/// Calls `read` on every `stride`-th proper prefix of `bytes` (all of the first 256): each must throw
/// FormatError.
template <typename Read>
void expect_prefixes_refused(const std::string& bytes, std::size_t stride, Read read) {
  for (std::size_t length = 0; length < bytes.size(); length += length < 256 ? 1 : stride) {
    EXPECT_THROW(read(bytes.substr(0, length)), FormatError) << "prefix of " << length << " bytes";
  }
}

/// One to four random edits: bits flipped, bytes replaced, inserted, removed, or runs of them copied about.
inline std::string mutate(std::string bytes) {
  Random& dice = random();
  for (std::uint64_t edits = 1 + dice.below(4); edits > 0 && !bytes.empty(); --edits) {
    const std::size_t at = dice.below(bytes.size());
    const std::size_t length = std::min<std::size_t>(1 + dice.below(16), bytes.size() - at);
    switch (dice.below(6)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << dice.below(8)));
        break;
      case 1:
        bytes[at] = static_cast<char>(dice.below(256));
        break;
      case 2:
        bytes[at] = dice.below(2) == 0 ? '\0' : '\xff';
        break;
      case 3:
        bytes.insert(at, length, static_cast<char>(dice.below(256)));
        break;
      case 4:
        bytes.erase(at, length);
        break;
      default:
        bytes.replace(dice.below(bytes.size()), length, bytes.substr(at, length));
        break;
    }
  }
  return bytes;
}

/// Calls `read` on `count` mutations of `bytes`: it must return or throw FormatError, nothing else.
template <typename Read>
void expect_mutations_survived(const std::string& bytes, int count, Read read) {
  for (int i = 0; i < count; ++i) {
    const std::string mutated = mutate(bytes);
    try {
      read(mutated);
    } catch (const FormatError&) {
    } catch (const std::exception& error) {
      ADD_FAILURE() << "mutation " << i << ": " << error.what();
    }
  }
}

}  // namespace phiz::test
