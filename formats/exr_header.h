#pragma once

#include <string_view>

namespace phiz {

constexpr int kLargestExrSide = 16384;

/// OpenEXR takes a header at its word: it makes room for what an attribute, a channel list or a tile says
/// before it looks whether the file goes on. This looks first: every attribute has the length its type has,
/// lies within the bytes and has a name of its own; the picture is not larger than the bytes can hold
/// (deflate: 1032 times). Throws FormatError; also for tiled, deep and multi-part files, which phiz does not
/// read. O(bytes of the header). Source: "OpenEXR File Layout", openexr.com, attribute types as of
/// OpenEXR 3.1.
void check_exr_header(std::string_view bytes);

}  // namespace phiz
