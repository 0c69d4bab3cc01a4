#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace phiz::readers {

enum class ScanFormat { ply, obj, stl_binary, stl_ascii, off, text, glb, drc, vdb };

/// By content; by extension (".ply", any case) where the content does not tell. Throws FormatError, with
/// advice, for what is none of ours.
ScanFormat recognise(std::span<const std::byte> bytes, const std::string& extension);

}  // namespace phiz::readers
