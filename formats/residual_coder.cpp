#include "formats/residual_coder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "formats/error.h"

namespace phiz {
namespace {

// Sizes of the four contexts, and the decisions of one number: zero, sign, then "more than k" up to kUnary.
constexpr int kClasses = 32, kSigns = 17, kFineClasses = 64;
constexpr int kSizes[4] = {kClasses * 5, kSigns* kClasses, kClasses* kClasses, kFineClasses};
constexpr int kNodes = 20, kUnary = 18;  // node 0: zero, 1: sign, 2 ..: more than 1, 2, ...
constexpr int kMixers = kNodes * 16;
constexpr int kMostEscapeBits = 24;
constexpr int kStretchLimit = 2047;
constexpr std::int32_t kFirstWeight = 65536 / 4, kMostWeight = 1 << 18;
constexpr int kLeast = 32, kMost = 65536 - 32;  // of a probability
constexpr int kSlowest = 128;                   // a probability moves by at least 1/128 of its error

/// Logistic function and its inverse in whole numbers; a stretched value counts 256ths. Made of plain
/// additions, products and quotients of doubles, which are the same everywhere, unlike a library's exp.
struct Tables {
  std::array<std::int16_t, 4096> stretch;  // of a probability's upper 12 bits
  std::array<std::uint16_t, 2 * kStretchLimit + 1> squash;
  std::array<std::uint16_t, kSlowest> rate;

  Tables() {
    double e = 0, term = 1;  // exp(1/256)
    for (int k = 1; k < 12; ++k) {
      e += term;
      term /= 256.0 * k;
    }
    double power = 1;
    for (int s = 0; s <= kStretchLimit; ++s) {
      const double share = 65536.0 * power / (1 + power);
      squash[kStretchLimit + s] = limited(std::floor(share + 0.5));
      squash[kStretchLimit - s] = limited(std::floor(65536.0 / (1 + power) + 0.5));
      power *= e;
    }
    int s = -kStretchLimit;
    for (int i = 0; i < 4096; ++i) {  // the least s whose probability reaches the middle of the cell
      while (s < kStretchLimit && squash[kStretchLimit + s] < 16 * i + 8) ++s;
      stretch[i] = static_cast<std::int16_t>(s);
    }
    for (int n = 0; n < kSlowest; ++n) rate[n] = static_cast<std::uint16_t>(131072 / (2 * n + 3));
  }

  static std::uint16_t limited(double share) {
    return static_cast<std::uint16_t>(std::clamp(share, double{kLeast}, double{kMost}));
  }
};

const Tables& tables() {
  static const Tables made;
  return made;
}

/// Four classes an octave: 0 for less than 2, 6 for 16.
int class_of(int sixteenths) {
  const unsigned x = static_cast<unsigned>(sixteenths) + 8;
  const int width = static_cast<int>(std::bit_width(x));
  return std::min(kClasses - 1, 4 * (width - 4) + static_cast<int>((x >> (width - 3)) & 3));
}

/// Eight an octave.
int fine_class_of(int sixteenths) {
  const unsigned x = static_cast<unsigned>(sixteenths) + 8;
  const int width = static_cast<int>(std::bit_width(x));
  return std::min(kFineClasses - 1, 8 * (width - 4) + static_cast<int>((x >> (width - 4)) & 7));
}

/// What a number counts as a neighbour: beyond it all is large.
int magnitude_of(std::int32_t number) {
  return std::min(std::abs(number), 4095);
}

/// A number is twice a whole and a rest of 0 or 1.
std::int32_t whole_of(std::int32_t number) {
  return number >> 1;
}
int rest_of(std::int32_t number) {
  return number & 1;
}

class BitWriter {
 public:
  int code(std::uint32_t one, int bit) {
    const std::uint32_t range = high_ - low_;
    const std::uint32_t middle = low_ + (range >> 16) * one + (((range & 0xffff) * one) >> 16);
    bit ? high_ = middle : low_ = middle + 1;
    while (((low_ ^ high_) & 0xff000000u) == 0) {
      bytes_.push_back(static_cast<char>(high_ >> 24));
      low_ <<= 8;
      high_ = high_ << 8 | 255;
    }
    return bit;
  }
  std::string finish() && {  // any number from low to high will do; absent bytes are read as zeros
    if (low_ > 0) bytes_.push_back(static_cast<char>((low_ >> 24) + 1));
    return std::move(bytes_);
  }

 private:
  std::uint32_t low_ = 0, high_ = 0xffffffffu;
  std::string bytes_;
};

class BitReader {
 public:
  explicit BitReader(std::string_view bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) value_ = value_ << 8 | next_byte();
  }
  int code(std::uint32_t one, int) {
    const std::uint32_t range = high_ - low_;
    const std::uint32_t middle = low_ + (range >> 16) * one + (((range & 0xffff) * one) >> 16);
    const int bit = value_ <= middle;
    bit ? high_ = middle : low_ = middle + 1;
    while (((low_ ^ high_) & 0xff000000u) == 0) {
      low_ <<= 8;
      high_ = high_ << 8 | 255;
      value_ = value_ << 8 | next_byte();
    }
    return bit;
  }

 private:
  std::uint32_t next_byte() { return at_ < bytes_.size() ? static_cast<unsigned char>(bytes_[at_++]) : 0u; }
  std::string_view bytes_;
  std::size_t at_ = 0;
  std::uint32_t low_ = 0, high_ = 0xffffffffu, value_ = 0;
};

}  // namespace

ResidualModel::ResidualModel()
    : nodes_(static_cast<std::size_t>(kSizes[0] + kSizes[1] + kSizes[2] + kSizes[3]) * kNodes),
      weights_(4 * kMixers, kFirstWeight),
      rests_(8) {}

ResidualModel::Contexts ResidualModel::find_contexts(const LevelTopology& level, std::size_t i,
                                                     const std::int32_t* numbers, int& slow_mean) const {
  const std::span<const int> earlier = level.earlier(i);
  int count = 0, size = 0, sum = 0, slow = 0, fine = 0;
  for (const int u : earlier) {
    if (count == 4) break;
    ++count;
    const std::int32_t whole = whole_of(numbers[u]);
    size += magnitude_of(whole);
    sum += std::clamp(whole, -4095, 4095);
    slow += slow_means_[u];
    fine += rest_of(numbers[u]) != 0;
  }
  const int near = count > 0 ? 16 * size / count : 0, sign = count > 0 ? 2 * sum / count : 0;
  slow_mean = count > 0 ? slow / count : last_slow_mean_;
  int coarse = slow_mean;
  if (!level.is_control()) {
    const auto& [a, b] = level.parents(i);
    coarse = (activities_[a] + activities_[b]) / 2;
  }
  const int around = class_of((16 * size + coarse) / (count + 1));
  const int contexts[4] = {around * 5 + count, (std::clamp(sign, -8, 8) + 8) * kClasses + class_of(near),
                           class_of(slow_mean) * kClasses + class_of(coarse),
                           fine_class_of((2 * slow_mean + near + coarse) / 4)};
  Contexts found{};
  int base = 0;
  for (int k = 0; k < 4; ++k) {
    found.places[k] = (base + contexts[k]) * kNodes;
    base += kSizes[k];
  }
  found.mixer = around / 2;
  found.sign_mixer = std::clamp(sign, -7, 7) + 7;
  if (!level.is_control()) {
    for (const int parent : level.parents(i)) fine += is_fine_[parent];
  }
  found.fine = std::min(fine, 3);
  return found;
}

void ResidualModel::learn(Probability& p, int bit) {
  // The product reaches 65535 * 43690: as a whole number of 64 bits, then a shift that rounds downwards.
  const std::int64_t step = std::int64_t{(bit ? 65535 : 0) - p.one} * tables().rate[p.seen];
  p.one = static_cast<std::uint16_t>(p.one + (step >> 16));
  p.seen = static_cast<std::uint16_t>(std::min<int>(p.seen + 1, kSlowest - 1));
}

template <class Coder>
int ResidualModel::code_bit(Coder& coder, const Contexts& contexts, int node, int mixer, int bit) {
  const Tables& table = tables();
  Probability* found[4];
  std::int32_t stretched[4];
  std::int32_t* weights = &weights_[4 * static_cast<std::size_t>(node * 16 + mixer)];
  std::int32_t sum = 0;
  for (int k = 0; k < 4; ++k) {
    found[k] = &nodes_[static_cast<std::size_t>(contexts.places[k] + node)];
    stretched[k] = table.stretch[found[k]->one >> 4];
    sum += (weights[k] * stretched[k]) >> 8;
  }
  const int mixed = std::clamp(sum >> 8, -kStretchLimit, kStretchLimit);
  const int one = table.squash[static_cast<std::size_t>(kStretchLimit + mixed)];
  bit = coder.code(static_cast<std::uint32_t>(one), bit);
  const std::int32_t error = (bit ? 65535 : 0) - one;
  for (int k = 0; k < 4; ++k) {
    weights[k] = std::clamp(weights[k] + ((stretched[k] * error + 8192) >> 14), -kMostWeight, kMostWeight);
    learn(*found[k], bit);
  }
  return bit;
}

template <class Coder>
std::int32_t ResidualModel::code_number(Coder& coder, const Contexts& contexts, std::int32_t number) {
  const std::int32_t size = std::abs(number);
  if (code_bit(coder, contexts, 0, contexts.mixer, size > 0) == 0) return 0;
  const int positive = code_bit(coder, contexts, 1, contexts.sign_mixer, number > 0);
  std::int32_t found = 1;
  while (found <= kUnary && code_bit(coder, contexts, 1 + found, contexts.mixer, size > found)) ++found;
  if (found > kUnary) {  // what is left, plus one: its length in ones, then its bits
    const auto rest = static_cast<std::uint32_t>(size - kUnary);
    const int width = size > kUnary ? static_cast<int>(std::bit_width(rest)) : 0;
    int bits = 1;
    while (coder.code(32768, bits < width)) {
      if (++bits > kMostEscapeBits) throw FormatError("a displacement is out of range");
    }
    std::uint32_t value = 1;
    for (int k = bits - 2; k >= 0; --k)
      value = value << 1 | static_cast<std::uint32_t>(coder.code(32768, static_cast<int>(rest >> k & 1)));
    found = kUnary + static_cast<std::int32_t>(value);
  }
  return positive ? found : -found;
}

/// Most numbers have none: whether is told by the numbers beside it that have one, and whether it is zero but
/// for it.
template <class Coder>
int ResidualModel::code_rest(Coder& coder, const Contexts& contexts, bool is_zero, int rest) {
  return code_plain_bit(coder, rests_[static_cast<std::size_t>(contexts.fine * 2 + is_zero)], rest);
}

template <class Coder>
int ResidualModel::code_plain_bit(Coder& coder, Probability& p, int bit) {
  const int one = std::clamp<int>(p.one, kLeast, kMost);
  bit = coder.code(static_cast<std::uint32_t>(one), bit);
  learn(p, bit);
  return bit;
}

template <class Coder>
void ResidualModel::code_level(const LevelTopology& level, Coder& coder, std::int32_t* numbers) {
  if (!level.is_control() && activities_.size() != level.first_new())
    throw FormatError("a level comes before the one that it refines");
  slow_means_.assign(level.new_count(), 0);
  last_slow_mean_ = 0;
  for (std::size_t i = 0; i < level.new_count(); ++i) {
    int slow_mean = 0;
    const Contexts contexts = find_contexts(level, i, numbers, slow_mean);
    const std::int32_t whole = code_number(coder, contexts, whole_of(numbers[i]));
    numbers[i] = 2 * whole + code_rest(coder, contexts, whole == 0, rest_of(numbers[i]));
    slow_means_[i] = last_slow_mean_ = (115 * 16 * magnitude_of(whole) + 141 * slow_mean) / 256;
  }
  close_level(level, {numbers, level.new_count()});
}

/// What the next level may expect about each vertex: half of what was coded at it, or, if it is older, about
/// it.
void ResidualModel::close_level(const LevelTopology& level, std::span<const std::int32_t> numbers) {
  activities_.assign(level.vertex_count(), 0);
  is_fine_.resize(level.vertex_count(), 0);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (rest_of(numbers[i]) == 0) continue;
    is_fine_[level.first_new() + i] = 1;
    if (level.is_control()) continue;
    for (const int parent : level.parents(i)) is_fine_[parent] = 1;
  }
  if (!level.is_control()) {
    std::vector<std::int32_t> counts(level.first_new(), 0);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      for (const int parent : level.parents(i)) {
        activities_[parent] += 8 * magnitude_of(whole_of(numbers[i]));
        ++counts[parent];
      }
    }
    for (std::size_t v = 0; v < counts.size(); ++v) activities_[v] /= std::max(counts[v], 1);
  }
  for (std::size_t i = 0; i < numbers.size(); ++i)
    activities_[level.first_new() + i] = 8 * magnitude_of(whole_of(numbers[i]));
}

std::string ResidualModel::encode(const LevelTopology& level, std::span<const std::int32_t> numbers) {
  std::vector<std::int32_t> copy(numbers.begin(), numbers.end());
  for (const std::int32_t number : copy) {
    if (std::abs(number) >= 1 << kMostEscapeBits) throw FormatError("a displacement is out of range");
  }
  BitWriter writer;
  code_level(level, writer, copy.data());
  return std::move(writer).finish();
}

std::vector<std::int32_t> ResidualModel::decode(const LevelTopology& level, std::string_view bytes) {
  if (level.new_count() > most_numbers(bytes.size()))
    throw FormatError("a stream is too short for its numbers");
  std::vector<std::int32_t> numbers(level.new_count(), 0);
  BitReader reader(bytes);
  code_level(level, reader, numbers.data());
  return numbers;
}

}  // namespace phiz
