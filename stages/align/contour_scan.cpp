#include "stages/align/contour_scan.h"

#include <algorithm>
#include <array>

namespace phiz {
namespace {

constexpr std::uint32_t kCodeBits = 3, kCodeMask = (1U << kCodeBits) - 1;
constexpr std::int32_t kSecondUnit = 1 << 16;
// Change of the two packed counters for each code: counter | downward.
constexpr std::array<std::int32_t, 6> kChanges = {
    1, -1, kSecondUnit, -kSecondUnit, 1 + kSecondUnit, -1 - kSecondUnit};

// A crossing is a fraction with a denominator of at most 2^30, and its double is off by less than 2^-35. So
// what is not an integer is at least 2^-30 from one, and rounding up after taking away 2^-33 is exact.
constexpr double kNudge = 1.0 / 8589934592.0;
constexpr std::int32_t kBias = 1 << 15;

std::int32_t round_up(double x) {
  return kBias - static_cast<std::int32_t>(kBias + kNudge - x);
}

void sort_few(std::uint32_t* begin, std::uint32_t* end) {
  for (std::uint32_t* at = begin; at < end; ++at) {
    const std::uint32_t value = *at;
    std::uint32_t* place = at;
    for (; place > begin && place[-1] > value; --place) *place = place[-1];
    *place = value;
  }
}

}  // namespace

void ContourScan::begin(int height) {
  height_ = height;
  edges_.clear();
  starts_.assign(static_cast<std::size_t>(height) + 1, 0);
}

void ContourScan::add_edge(std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1,
                           Counter counter) {
  auto code = static_cast<std::uint32_t>(counter);
  if (y0 < y1) {
    code |= 1;
  } else {
    std::swap(x0, x1);
    std::swap(y0, y1);
  }
  const std::int32_t first = std::max((y0 + kSub / 2 - 1) >> kSubBits, 0);
  const std::int32_t end = std::min((y1 + kSub / 2 - 1) >> kSubBits, height_);
  if (first >= end) return;
  const double slope = static_cast<double>(x1 - x0) / static_cast<double>(y1 - y0);
  const double down = static_cast<double>(first * kSub + kSub / 2 - y0);
  const double x = (static_cast<double>(x0 - kSub / 2) + down * slope) * (1.0 / kSub);
  edges_.push_back({x, slope, first, end, code});
  ++starts_[static_cast<std::size_t>(first)];
  --starts_[static_cast<std::size_t>(end)];
}

// Turns the changes at the ends of edges into places for each row's events, and writes the events there.
void ContourScan::scatter(int width) {
  std::uint32_t active = 0, place = 0;
  ends_.resize(starts_.size());
  for (std::size_t y = 0; y < starts_.size(); ++y) {
    active += starts_[y];
    starts_[y] = ends_[y] = place;
    place += active;
  }
  if (events_.size() < place) events_.resize(place);
  for (const Edge& edge : edges_) {
    double step = 0;
    for (std::int32_t y = edge.first_row; y < edge.end_row; ++y, step += 1) {
      const std::int32_t column = std::max(round_up(edge.x + step * edge.slope), 0);
      if (column >= width) continue;
      events_[ends_[static_cast<std::size_t>(y)]++] =
          static_cast<std::uint32_t>(column) << kCodeBits | edge.code;
    }
  }
}

void ContourScan::fill(Silhouette& out) {
  scatter(out.width());
  for (int y = 0; y < height_; ++y) {
    std::uint32_t* const begin = events_.data() + starts_[static_cast<std::size_t>(y)];
    std::uint32_t* const end = events_.data() + ends_[static_cast<std::size_t>(y)];
    sort_few(begin, end);
    std::int32_t total = 0;
    int span_begin = 0;
    for (const std::uint32_t* event = begin; event != end; ++event) {
      const auto column = static_cast<int>(*event >> kCodeBits);
      if (total == 0) span_begin = column;
      total += kChanges[*event & kCodeMask];
      if (total == 0 && span_begin < column) out.fill_span(y, span_begin, column);
    }
    if (total != 0) out.fill_span(y, span_begin, out.width());
  }
}

}  // namespace phiz
