#pragma once

#include <cstdint>
#include <vector>

#include "stages/align/silhouette.h"

namespace phiz {

/// Scan conversion of directed outlines in fixed point: each edge changes two counters for all pixels right
/// of it, and a pixel is set where one of them is not zero. Rows: centres in [top, bottom) of the edge.
/// Columns: from the first pixel whose centre is not left of the edge. Together this is the top-left rule.
/// Buffers are kept between pictures.
class ContourScan {
 public:
  static constexpr int kSubBits = 8;
  static constexpr std::int32_t kSub = 1 << kSubBits;
  static constexpr std::int32_t kReach = 8192 * kSub;  ///< coordinates must lie within +-kReach

  enum class Counter : std::uint32_t { kFirst = 0, kSecond = 2, kBoth = 4 };

  void begin(int height);
  /// From (x0, y0) to (x1, y1) in 1/kSub pixels, y down. Upward edges add one to the counter, downward edges
  /// take one away.
  void add_edge(std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1, Counter counter);
  /// Sets the pixels; `out` has the height given to begin().
  void fill(Silhouette& out);

 private:
  struct Edge {
    double x, slope;  ///< column of the crossing (in pixels, centres at integers) at first_row, and its
                      ///< change a row
    std::int32_t first_row, end_row;
    std::uint32_t code;
  };
  void scatter(int width);

  int height_ = 0;
  std::vector<Edge> edges_;
  std::vector<std::uint32_t> starts_, ends_;  ///< per row, into events_
  std::vector<std::uint32_t> events_;         ///< column << 3 | code
};

}  // namespace phiz
