#pragma once

#include <cstddef>
#include <span>

#include "formats/scan_file.h"

namespace phiz::readers {

/// One reader a format; contract as parse_scan, without recognition. Throw FormatError.

/// Elements and properties in any order; `vertex` (x y z, nx ny nz, red green blue or r g b or diffuse_*,
/// confidence or else quality within [0,1]); `face` with a list vertex_indices or vertex_index. One row of an
/// element a line.
ScanFile read_ply(std::span<const std::byte> bytes, const ScanLimits& limits);

/// v x y z [w] | v x y z r g b, vn, f with 1-based or negative indices. A vertex has the mean of its corners'
/// normals.
ScanFile read_obj(std::span<const std::byte> bytes, const ScanLimits& limits);

/// Three vertices of their own for each triangle, as in the file.
ScanFile read_stl_binary(std::span<const std::byte> bytes, const ScanLimits& limits);
ScanFile read_stl_ascii(std::span<const std::byte> bytes, const ScanLimits& limits);

/// OFF with C, N and ST in front, as text.
ScanFile read_off(std::span<const std::byte> bytes, const ScanLimits& limits);

/// Columns of numbers: names from a header line, else by count (see columns.cpp).
ScanFile read_text(std::span<const std::byte> bytes, const ScanLimits& limits);

/// All triangle and point primitives of the scene, node transforms applied.
ScanFile read_glb(std::span<const std::byte> bytes, const ScanLimits& limits);

ScanFile read_drc(std::span<const std::byte> bytes, const ScanLimits& limits);

ScanFile read_vdb(std::span<const std::byte> bytes, const ScanLimits& limits);

}  // namespace phiz::readers
