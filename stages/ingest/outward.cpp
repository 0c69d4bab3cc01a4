#include "stages/ingest/outward.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "stages/geometry/parallel.h"
#include "stages/geometry/point_index.h"

namespace phiz {
namespace {

constexpr float kSameSheetDot = 0.8f;  ///< normals of points of one sheet in one cell
constexpr int kRounds = 128;
constexpr float kCoupling = 2.0f;  ///< of a neighbour that runs on straight, against an open half space
constexpr float kGain = 0.1f;      ///< of a round: low, so that evidence travels before anything is settled

/// Rays through the occupied cells of a lattice.
class Visibility {
 public:
  Visibility(const PointGrid& grid) : grid_(grid) {
    occupied_.resize(grid.cell_count());
    for (std::size_t c = 0; c < occupied_.size(); ++c) occupied_[c] = grid.cell_end(c) > grid.cell_begin(c);
    // Directions in a cone of 65 degrees about +z: one ring of five and one of nine.
    for (int i = 0; i < 14; ++i) {
      const float tilt = (i < 5 ? 28.0f : 60.0f) * std::numbers::pi_v<float> / 180;
      const float turn = (i < 5 ? i / 5.0f : (i - 5) / 9.0f) * 2 * std::numbers::pi_v<float>;
      cone_.push_back({std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), std::cos(tilt)});
    }
  }

  /// Share of the cone about `axis` that is open, by how far the rays get.
  float openness(const Eigen::Vector3f& p, const Eigen::Vector3f& axis) const {
    Eigen::Matrix3f frame;
    frame.col(2) = axis;
    frame.col(0) = axis.unitOrthogonal();
    frame.col(1) = axis.cross(frame.col(0));
    float open = 0;
    for (const auto& d : cone_) open += reach(p, frame * d);
    return open / cone_.size();
  }

 private:
  float reach(const Eigen::Vector3f& p, const Eigen::Vector3f& direction) const {
    const float step = grid_.cell();
    for (int k = 0; k < 128; ++k) {
      const Eigen::Vector3i c = grid_.coordinates(p + (2.2f + k) * step * direction);
      if (!grid_.contains(c)) return 1.0f;
      if (occupied_[grid_.cell_index(c)]) return std::min(0.2f, k / 100.0f);
    }
    return 1.0f;
  }

  const PointGrid& grid_;
  std::vector<char> occupied_;
  std::vector<Eigen::Vector3f> cone_;
};

/// Which way the guide's surface faces where it runs most alike: in [-1, 1], near 0 far from the guide.
float guide_vote(const OrientationGuide& guide, const PointIndex& index, const Eigen::Vector3f& p,
                 const Eigen::Vector3f& n, std::vector<PointIndex::Neighbour>& near) {
  constexpr float kReachMm = 14.0f, kNormalMm = 10.0f;
  index.find_nearest(p, 12, near);
  float best_cost = std::numeric_limits<float>::max(), vote = 0;
  for (const auto& neighbour : near) {
    const float along = guide.normals[neighbour.point_idx].dot(n);
    const float cost = neighbour.squared_distance + 2 * kNormalMm * kNormalMm * (1 - std::abs(along));
    if (cost >= best_cost) continue;
    best_cost = cost;
    vote = along * std::exp(-cost / (kReachMm * kReachMm));
  }
  return vote;
}

/// The points of one cell whose normals are alike up to their sign.
struct Sheet {
  Eigen::Vector3f normal, position;  ///< of the first point; the mean
  int points = 0;
  float evidence = 0;  ///< > 0: `normal` seems to point outward
};

/// Into (-1, 1), odd, slope 1 at 0.
float saturate(float x) {
  return x / std::sqrt(1 + x * x);
}

/// Neighbouring sheets with the weight of their agreement; negative where the normals are opposed.
struct Bonds {
  std::vector<int> offsets{0}, sheets;
  std::vector<float> weights;
};

/// 1 where one surface runs on from a to b, 0 where they are layers or corners, with the sign of the normals.
float bond(const Sheet& a, const Sheet& b) {
  const float along = a.normal.dot(b.normal);
  const Eigen::Vector3f d = (b.position - a.position).normalized();
  const float rise = std::max(std::abs(d.dot(a.normal)), std::abs(d.dot(b.normal)));
  return along * std::max(0.0f, 1 - 1.3f * rise);
}

class Sheets {
 public:
  Sheets(const PointGrid& grid, const std::vector<Eigen::Vector3f>& normals)
      : grid_(grid), sheet_of_slot_(grid.size()), first_(grid.cell_count() + 1, 0) {
    for (std::size_t c = 0; c < grid.cell_count(); ++c) {
      first_[c] = static_cast<int>(sheets_.size());
      for (int slot = grid.cell_begin(c); slot < grid.cell_end(c); ++slot) add(slot, normals, first_[c]);
    }
    first_.back() = static_cast<int>(sheets_.size());
    for (Sheet& sheet : sheets_) sheet.position /= static_cast<float>(sheet.points);
  }

  void weigh_evidence(const OrientationGuide& guide) {
    const Visibility visibility(grid_);
    const PointIndex index(guide.positions);
    parallel_for(sheets_.size(), 512, [&](std::size_t begin, std::size_t end) {
      std::vector<PointIndex::Neighbour> near;
      for (std::size_t i = begin; i < end; ++i) {
        Sheet& s = sheets_[i];
        s.evidence = visibility.openness(s.position, s.normal) - visibility.openness(s.position, -s.normal) +
                     0.5f * guide_vote(guide, index, s.position, s.normal, near);
      }
    });
  }

  /// Which sheets' normals point inward. Mean field of a spin glass: every sheet listens to its own evidence
  /// and to what the sheets that continue it have come to believe.
  std::vector<char> find_inward() const {
    const Bonds bonds = find_bonds();
    std::vector<float> belief(sheets_.size()), next(sheets_.size());
    for (std::size_t i = 0; i < belief.size(); ++i) belief[i] = saturate(kGain * sheets_[i].evidence);
    for (int round = 0; round < kRounds; ++round) {
      parallel_for(sheets_.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          float sum = sheets_[i].evidence;
          for (int k = bonds.offsets[i]; k < bonds.offsets[i + 1]; ++k)
            sum += kCoupling * bonds.weights[k] * belief[bonds.sheets[k]];
          next[i] = 0.5f * (belief[i] + saturate(kGain * sum));
        }
      });
      belief.swap(next);
    }
    std::vector<char> inward(sheets_.size());
    for (std::size_t i = 0; i < inward.size(); ++i) inward[i] = belief[i] < 0;
    return inward;
  }

  const Sheet& sheet_of_slot(int slot) const { return sheets_[sheet_of_slot_[slot]]; }
  int sheet_index(int slot) const { return sheet_of_slot_[slot]; }

 private:
  void add(int slot, const std::vector<Eigen::Vector3f>& normals, int first) {
    const Eigen::Vector3f& n = normals[grid_.order()[slot]];
    int best = -1;
    float most = kSameSheetDot;
    for (int i = first; i < static_cast<int>(sheets_.size()); ++i) {
      const float alike = std::abs(sheets_[i].normal.dot(n));
      if (alike > most) most = alike, best = i;
    }
    if (best < 0) {
      best = static_cast<int>(sheets_.size());
      sheets_.push_back({n, Eigen::Vector3f::Zero(), 0, 0});
    }
    sheets_[best].position += grid_.sorted_points()[slot];
    ++sheets_[best].points;
    sheet_of_slot_[slot] = best;
  }

  Bonds find_bonds() const {
    Bonds bonds;
    for (const Sheet& sheet : sheets_) {
      const Eigen::Vector3i at = grid_.coordinates(sheet.position);
      for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
          for (int x = -1; x <= 1; ++x) {
            const Eigen::Vector3i c = at + Eigen::Vector3i(x, y, z);
            if ((x | y | z) == 0 || !grid_.contains(c)) continue;
            const std::size_t cell = grid_.cell_index(c);
            for (int i = first_[cell]; i < first_[cell + 1]; ++i) {
              const float weight = bond(sheet, sheets_[i]);
              if (weight != 0) bonds.sheets.push_back(i), bonds.weights.push_back(weight);
            }
          }
      bonds.offsets.push_back(static_cast<int>(bonds.sheets.size()));
    }
    return bonds;
  }

  const PointGrid& grid_;
  std::vector<Sheet> sheets_;
  std::vector<int> sheet_of_slot_, first_;
};

}  // namespace

void turn_outward(const PointGrid& coarse, const OrientationGuide& guide,
                  std::vector<Eigen::Vector3f>& normals) {
  Sheets sheets(coarse, normals);
  sheets.weigh_evidence(guide);
  const std::vector<char> inward = sheets.find_inward();
  for (std::size_t slot = 0; slot < coarse.size(); ++slot) {
    Eigen::Vector3f& n = normals[coarse.order()[slot]];
    const bool against = sheets.sheet_of_slot(static_cast<int>(slot)).normal.dot(n) < 0;
    if (against != (inward[sheets.sheet_index(static_cast<int>(slot))] != 0)) n = -n;
  }
}

}  // namespace phiz
