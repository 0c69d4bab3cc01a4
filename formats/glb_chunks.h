#pragma once

#include <string>
#include <string_view>

namespace phiz {

/// The two chunks of a binary glTF file (glTF 2.0 specification, section 4).
struct GlbChunks {
  std::string_view json;
  std::string_view bin;  ///< empty if there is none; may end in up to three padding bytes
};

/// Chunks are padded to four bytes, JSON with spaces and BIN with zeros.
std::string join_glb(std::string_view json, std::string_view bin);

/// Views into `bytes`. Throws FormatError with the byte where lengths do not fit or the kinds are not JSON,
/// BIN.
GlbChunks split_glb(std::string_view bytes);

}  // namespace phiz
