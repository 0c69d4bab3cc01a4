#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace phiz {

/// SHA-256 of `bytes` in 64 hexadecimal digits, with the `length` bytes from `offset` taken as '0', so that
/// the digest of a file can stand in the file. `offset + length` must lie within. O(bytes).
std::string digest_without(std::string_view bytes, std::size_t offset, std::size_t length);

/// OpenVDB marks each file with a random UUID (bytes 21 to 56). Ours is made from the content instead: same
/// content, same bytes, and whether a file is whole can be told before OpenVDB, which does not check, sees
/// it. It has the form `7068697a-dddd-8ddd-addd-dddddddddddd` (version 8; the first group says "phiz"; d:
/// digest).
void seal_vdb(std::string& bytes);

/// Throws FormatError where `bytes` are no OpenVDB file, or bear our mark and are damaged. Files of other
/// programs pass unseen.
void check_vdb_seal(std::string_view bytes);

}  // namespace phiz
