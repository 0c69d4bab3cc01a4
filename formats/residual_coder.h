#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/level_topology.h"

namespace phiz {

/// Codes the whole numbers of one level after another: most are small, and how small is told by the numbers
/// around them. An adaptive binary arithmetic coder; each decision is predicted from four contexts (numbers
/// already coded beside the vertex, their slow mean, the coarser level around it) that are mixed in the
/// logistic domain. Whole numbers throughout, so that every machine and the viewer decode the same.
/// README_HEAD_ASSET.md is the specification. After Mahoney, "Adaptive weighing of context models for
/// lossless data compression", 2005.
class ResidualModel {
 public:
  ResidualModel();

  /// One number for each new vertex of the level, in order; |number| < 2^24. Levels go from 0 upwards without
  /// a gap: what was learned carries over. 30 to 60 ns a number.
  std::string encode(const LevelTopology& level, std::span<const std::int32_t> numbers);

  /// The inverse. Never fails on noise: it gives other numbers. Throws FormatError if a number is out of
  /// range.
  std::vector<std::int32_t> decode(const LevelTopology& level, std::string_view bytes);

  /// A probability never falls below 2^-11, so that a stream of so many bytes holds no more numbers than
  /// this: to be checked before numbers are allocated.
  static std::size_t most_numbers(std::size_t stream_bytes) { return 32768 * (stream_bytes + 8); }

 private:
  template <class Coder>
  void code_level(const LevelTopology& level, Coder& coder, std::int32_t* numbers);
  void close_level(const LevelTopology& level, std::span<const std::int32_t> numbers);

  struct Probability {
    std::uint16_t one = 32768;  ///< of a 1, of 65536
    std::uint16_t seen = 0;
  };
  struct Contexts {
    int places[4];  ///< first node of each context's tree
    int mixer;
    int sign_mixer;
    int fine;
  };
  Contexts find_contexts(const LevelTopology& level, std::size_t i, const std::int32_t* numbers,
                         int& slow_mean) const;
  template <class Coder>
  int code_bit(Coder& coder, const Contexts& contexts, int node, int mixer, int bit);
  template <class Coder>
  std::int32_t code_number(Coder& coder, const Contexts& contexts, std::int32_t number);

  template <class Coder>
  int code_rest(Coder& coder, const Contexts& contexts, bool is_zero, int rest);
  template <class Coder>
  int code_plain_bit(Coder& coder, Probability& p, int bit);
  static void learn(Probability& p, int bit);

  std::vector<Probability> nodes_;     ///< all contexts' trees
  std::vector<std::int32_t> weights_;  ///< four a mixer, 16 fractional bits
  std::vector<Probability> rests_;
  std::vector<char> is_fine_;             ///< of each vertex: it or one beside it had a rest
  std::vector<std::int32_t> activities_;  ///< of each vertex of the level before, 16ths
  std::vector<std::int32_t> slow_means_;  ///< of each new vertex of this level, 16ths
  std::int32_t last_slow_mean_ = 0;
};

}  // namespace phiz
