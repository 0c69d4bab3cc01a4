#pragma once

#include "formats/scan_file.h"

namespace phiz {

/// `samples` points by area on the triangles of a scan, one per equal slice of the cumulated area at a fixed
/// low-discrepancy place: no randomness, the same for any thread count. Colours are interpolated; vertices
/// that no triangle uses are not sampled. Triangles with a non-finite corner have no area.
PointCloud sample_soup(const ScanFile& scan, int samples);

}  // namespace phiz
