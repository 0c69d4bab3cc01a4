#include <algorithm>
#include <bit>
#include <numeric>

#include "stages/align/silhouette.h"

namespace phiz {
namespace {

/// A stretch of equal pixels in one row.
struct Run {
  int y, begin, end;
};

// First pixel at or after x whose value is `value`, or the width.
int find_next(std::span<const std::uint64_t> row, int width, int x, bool value) {
  while (x < width) {
    const std::uint64_t word =
        (value ? row[static_cast<std::size_t>(x) / 64] : ~row[static_cast<std::size_t>(x) / 64]) >> (x % 64);
    if (word != 0) return x + std::countr_zero(word);
    x = (x / 64 + 1) * 64;
  }
  return width;
}

std::vector<Run> find_runs(const Silhouette& silhouette, bool value) {
  std::vector<Run> runs;
  for (int y = 0; y < silhouette.height(); ++y) {
    const auto row = silhouette.row(y);
    for (int x = find_next(row, silhouette.width(), 0, value); x < silhouette.width();) {
      const int end = find_next(row, silhouette.width(), x, !value);
      runs.push_back({y, x, end});
      x = find_next(row, silhouette.width(), end, value);
    }
  }
  return runs;
}

/// Connected regions of runs: union-find with the smaller index as root.
class Regions {
 public:
  /// `reach` 0: runs of neighbouring rows touch where they overlap (4-connected); 1: corners count too
  /// (8-connected).
  Regions(const std::vector<Run>& runs, int reach) : parent_(runs.size()), area_(runs.size(), 0) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
    std::size_t above = 0;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      while (above < i && (runs[above].y < runs[i].y - 1 ||
                           (runs[above].y == runs[i].y - 1 && runs[above].end + reach <= runs[i].begin)))
        ++above;
      for (std::size_t k = above; k < i && runs[k].y == runs[i].y - 1 && runs[k].begin < runs[i].end + reach;
           ++k)
        join(k, i);
    }
    for (std::size_t i = 0; i < runs.size(); ++i) area_[root(i)] += runs[i].end - runs[i].begin;
  }

  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  std::int64_t area(std::size_t i) { return area_[root(i)]; }

 private:
  void join(std::size_t a, std::size_t b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }
  std::vector<std::size_t> parent_;
  std::vector<std::int64_t> area_;
};

void widen_rows(Silhouette& silhouette) {
  for (int y = 0; y < silhouette.height(); ++y) {
    const auto row = silhouette.row(y);
    std::uint64_t before = 0;
    for (std::size_t k = 0; k < row.size(); ++k) {
      const std::uint64_t word = row[k], after = k + 1 < row.size() ? row[k + 1] : 0;
      row[k] = word | word << 1 | word >> 1 | before >> 63 | after << 63;
      before = word;
    }
  }
}

void widen_columns(Silhouette& silhouette) {
  std::vector<std::uint64_t> before(static_cast<std::size_t>(silhouette.words_per_row()), 0);
  for (int y = 0; y < silhouette.height(); ++y) {
    const auto row = silhouette.row(y);
    const auto below = y + 1 < silhouette.height() ? silhouette.row(y + 1) : std::span<std::uint64_t>{};
    for (std::size_t k = 0; k < row.size(); ++k) {
      const std::uint64_t word = row[k];
      row[k] = word | before[k] | (below.empty() ? 0 : below[k]);
      before[k] = word;
    }
  }
}

void invert(Silhouette& silhouette) {
  for (std::uint64_t& word : silhouette.words()) word = ~word;
}

}  // namespace

std::int64_t fill_enclosed_holes(Silhouette& silhouette, std::int64_t max_area) {
  const std::vector<Run> runs = find_runs(silhouette, false);
  Regions regions(runs, 0);
  std::vector<char> outside(runs.size(), 0);
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (runs[i].y == 0 || runs[i].y == silhouette.height() - 1 || runs[i].begin == 0 ||
        runs[i].end == silhouette.width())
      outside[regions.root(i)] = 1;
  std::int64_t changed = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (outside[regions.root(i)] || regions.area(i) > max_area) continue;
    silhouette.fill_span(runs[i].y, runs[i].begin, runs[i].end);
    changed += runs[i].end - runs[i].begin;
  }
  return changed;
}

std::int64_t remove_specks(Silhouette& silhouette, std::int64_t min_area) {
  const std::vector<Run> runs = find_runs(silhouette, true);
  Regions regions(runs, 1);
  std::int64_t changed = 0;
  silhouette.clear();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (regions.area(i) >= min_area) {
      silhouette.fill_span(runs[i].y, runs[i].begin, runs[i].end);
    } else {
      changed += runs[i].end - runs[i].begin;
    }
  }
  return changed;
}

void grow(Silhouette& silhouette, int radius) {
  if (radius < 0) invert(silhouette);
  for (int k = 0; k < std::abs(radius); ++k) {
    widen_rows(silhouette);
    widen_columns(silhouette);
  }
  if (radius < 0) invert(silhouette);
}

}  // namespace phiz
