#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "stages/animate/point4.h"
#include "stages/animate/surface_plan.h"

namespace phiz {

/// A subject's displaced surface while its control vertices move: the same surface as evaluate_surface, in
/// float (within 0.001 mm). Detail rides on the moving normals of each level. Nothing is allocated after
/// construction; one thread; a whole evaluation and any sequence of local ones give the same bits.
/// Jeong, Kaehler, Haber, Seidel 2002, section 6.
class LivingSurface {
 public:
  /// displacements_mm as in HeadAsset; absent levels displace nothing. Throws InvalidInput where sizes
  /// differ. 33 bytes a vertex of the plan's finest level.
  LivingSurface(std::shared_ptr<const SurfacePlan> plan,
                std::span<const std::vector<float>> displacements_mm);

  /// All control vertices (mm) at once, levels 0 .. level. O(V(level)): about 10 ns a vertex.
  void evaluate(std::span<const Eigen::Vector3f> control_positions, int level);

  /// Notes where a control vertex goes; refresh brings the surface there. The first call of all has to be
  /// evaluate.
  void move(int vertex_idx, const Eigen::Vector3f& position);
  /// Levels 0 .. level after moves: what depends on moved vertices, level by level; whole levels where that
  /// is less work or where the level is finer than the one before. O(vertices that depend on moved ones).
  void refresh(int level);

  int level() const { return level_; }  ///< -1 before the first evaluation
  /// Of the current level, mm; the fourth number is 0. Vertex order as in SubdivisionHierarchy.
  std::span<const Point4> positions() const;
  int updated_count() const { return updated_; }  ///< vertices that the last call computed
  const SurfacePlan& plan() const { return *plan_; }
  /// What a whole evaluation reads and writes at least once.
  std::size_t bytes_touched(int level) const;

 private:
  struct Dirty {
    std::vector<std::uint32_t> stamps;  ///< the epoch in which a vertex was listed
    std::vector<int> list;              ///< as long as there are vertices; `count` are in use
    int count = 0;
    void add(int vertex_idx, std::uint32_t epoch) {
      if (stamps[vertex_idx] == epoch) return;
      stamps[vertex_idx] = epoch;
      list[count++] = vertex_idx;
    }
  };

  void evaluate_level(int k);
  void update_level(int k);
  void update_support(int k, bool is_more_to_come);

  std::shared_ptr<const SurfacePlan> plan_;
  std::vector<std::vector<float>> displacements_;  ///< of each level's own vertices; empty: none
  std::vector<Point4> buffer_;
  Dirty refined_, displaced_;  ///< displaced_ keeps all levels: what the next one starts from
  std::uint32_t epoch_ = 1;
  int level_ = -1, updated_ = 0;
  int moved_ = kNone;  ///< the one control vertex that moved, or how many did
  static constexpr int kNone = -1, kSeveral = -2;
};

/// Picks the level of a frame by a time budget. Times are the caller's: no clock in here.
class LevelChooser {
 public:
  explicit LevelChooser(int finest) : seconds_(static_cast<std::size_t>(finest) + 1, 0.0) {}
  /// What a frame at `level` took.
  void record(int level, double seconds);
  /// The finest level expected to fit; 0 where none does. Levels never tried are taken to cost four times
  /// the next coarser one.
  int choose(double budget_seconds) const;

 private:
  std::vector<double> seconds_;  ///< smoothed; 0: never tried
};

}  // namespace phiz
