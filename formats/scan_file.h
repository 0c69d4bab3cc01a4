#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/point_cloud.h"

namespace phiz {

/// What a scan file holds, as it is: points with their attributes, and triangles where the file has faces.
/// Polygons are fanned. Units and axes are those of the file. Positions may be non-finite: `ingest` removes
/// them. Coordinates are read as double and stored as float relative to `origin`, so that a scan far from
/// zero keeps its precision: true position = origin + positions[i]. `origin` is zero unless the middle
/// (median) of the first 4096 points is more than 100 times farther from zero than they spread; then it is
/// that middle, rounded to integers. Attributes are there for all points or for none; normals are scaled to
/// unit length (zero where unknown), colours are sRGB, confidences in [0,1]. A triangle soup keeps its
/// duplicates.
struct ScanFile {
  PointCloud points;
  std::vector<Eigen::Vector3i> triangles;  ///< empty for a point cloud; indices are checked to be in range
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  std::string format;  ///< "ply", "obj", "stl", "off", "text", "glb", "drc", "vdb"
};

struct ScanLimits {
  std::uint64_t max_points = 200'000'000;  ///< refused before anything is allocated
};

/// Reads a whole scan from memory. The format is recognised by content first, by `extension` (".ply", any
/// case) where content does not tell. Reads PLY (ascii, little and big endian, any property order and type),
/// OBJ, STL (ascii and binary), OFF, XYZ/PTS/CSV text, GLB (with Draco too), Draco, OpenVDB points. Counts in
/// a header are checked against the bytes that are there before allocation. Throws FormatError with line or
/// byte. O(bytes); peak memory <= 3x the raw float data beside the input bytes.
ScanFile parse_scan(std::span<const std::byte> bytes, const std::string& extension,
                    const ScanLimits& limits = {});

/// parse_scan on a file or a pipe, read once. Throws FormatError, its path in front ("a.ply: no such file");
/// also: missing, a directory, no permission, empty, a device.
ScanFile read_scan_file(const std::filesystem::path& path, const ScanLimits& limits = {});

}  // namespace phiz
