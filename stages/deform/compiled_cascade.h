#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/deformation.h"

namespace phiz {

struct NeutralSurface;
struct SampledFields;

/// Which instructions: all give the same bits. kBest is what the machine has.
enum class VectorPath { kBest, kPlain, kAvx2 };
bool has_vector_path(VectorPath path);

/// The cascade of one subject at the points of its neutral surface, ready to be played. Neighbouring fields
/// of one type are one loop; blocks of 16 points (in the order of a curve through the (u,v) square) name the
/// fields that are not zero there, and fields whose amount is zero are passed over. Vectors are kept in the
/// subject's axes as int16 with one step a field: its largest component / 32767, 0.0006 mm for a field of 20
/// mm.
class CompiledCascade {
 public:
  static constexpr int kBlockPoints = 16;

  /// `fields` sampled at the points of `neutral`. Throws as Cascade does. 3 ms for 25,000 points and 52
  /// fields.
  CompiledCascade(const Deformation& deformation, const SampledFields& fields, const NeutralSurface& neutral);

  std::size_t point_count() const { return order_.size(); }
  std::size_t parameter_count() const { return parameter_count_; }

  /// Where all points are. With every amount zero these are the neutral positions, bit for bit. Finite
  /// parameters, point_count() positions. One thread; const calls from several are safe. 0.1 ms for 25,000
  /// points and a usual expression.
  void evaluate(std::span<const float> parameters, std::span<Eigen::Vector3f> positions,
                VectorPath path = VectorPath::kBest) const;

  /// Bytes that evaluate reads and writes for these parameters, each once.
  std::size_t bytes_touched(std::span<const float> parameters) const;
  /// Largest distance to the plain cascade: half steps of the active fields, and float's rounding.
  double error_bound_mm(std::span<const float> parameters) const;

  // What the kernels see.
  enum class Kind : std::uint8_t { kNeutral, kConstant, kCopy, kLinear, kRotate, kBlend };
  struct Operation {
    Kind kind = Kind::kNeutral;
    int slot = 0, source = 0;  ///< block buffers: the one it changes, the one it looks at
    int constant = 0;          ///< which of constants_
    Eigen::Vector3f axis_point = Eigen::Vector3f::Zero(), axis_direction = Eigen::Vector3f::UnitX();
    std::vector<int> steps;  ///< fused, in order
  };
  struct Entry {
    std::uint32_t offset = 0;  ///< into data_
    std::uint32_t step = 0;    ///< into the amounts
  };
  static constexpr int kMostSlots = 8;

 private:
  friend struct CascadeCompiler;
  std::vector<float> make_amounts(std::span<const float> parameters) const;

  std::size_t parameter_count_ = 0;
  int result_slot_ = 0;
  std::vector<Operation> operations_;
  std::vector<int> step_parameters_;             ///< -1: the gain alone
  std::vector<double> step_gains_, step_steps_;  ///< of each step; step_steps_: one unit of its int16
  std::vector<double> step_levers_;              ///< mm that one unit of a mask can move, 1 for vectors
  std::vector<int> order_;                       ///< point at each place of the blocks
  std::vector<float> neutral_;                   ///< blocks of 48, padded with the last point
  std::vector<std::vector<float>> constants_;
  std::vector<std::uint32_t> entry_offsets_;  ///< [block * operations + operation], one more at the end
  std::vector<Entry> entries_;
  std::vector<std::int16_t> data_;  ///< in the order in which it is read
};

}  // namespace phiz
