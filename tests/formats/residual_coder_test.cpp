#include "formats/residual_coder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "formats/error.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

LevelTopology control_of(int rings) {
  const TriangleMesh disk = test::disk(8, rings);
  return {disk.triangles, disk.vertex_count()};
}

std::vector<std::int32_t> noise(std::size_t count, double size) {
  std::vector<std::int32_t> numbers;
  for (std::size_t i = 0; i < count; ++i)
    numbers.push_back(static_cast<std::int32_t>(std::lround(size * test::random().normal())));
  return numbers;
}

TEST(ResidualModel, GivesBackWhatItWasGiven) {
  for (const double size : {0.0, 0.3, 5.0, 1000.0, 2e6}) {
    ResidualModel encoder, decoder;
    LevelTopology level = control_of(5);
    for (int k = 0; k < 4; ++k) {
      if (k > 0) level = level.next();
      const std::vector<std::int32_t> numbers = noise(level.new_count(), size);
      EXPECT_EQ(decoder.decode(level, encoder.encode(level, numbers)), numbers);
    }
  }
}

TEST(ResidualModel, RefusesNumbersOutOfRange) {
  const LevelTopology level = control_of(2);
  std::vector<std::int32_t> numbers(level.new_count(), 0);
  numbers[3] = 1 << 24;
  EXPECT_THROW(ResidualModel().encode(level, numbers), FormatError);
}

TEST(ResidualModel, ZerosCostNearlyNothingAndAreNotRefused) {
  LevelTopology level = control_of(20);
  ResidualModel encoder, decoder;
  for (int k = 0; k < 5; ++k) {
    if (k > 0) level = level.next();
    const std::vector<std::int32_t> zeros(level.new_count(), 0);
    const std::string bytes = encoder.encode(level, zeros);
    EXPECT_LT(bytes.size(), 64u + zeros.size() / 4000);
    EXPECT_EQ(decoder.decode(level, bytes), zeros);
  }
}

TEST(ResidualModel, AStreamTooShortForItsNumbersIsRefusedBeforeTheyAreMade) {
  LevelTopology level = control_of(20);
  for (int k = 0; k < 6; ++k) level = level.next();
  ASSERT_GT(level.new_count(), ResidualModel::most_numbers(0));
  EXPECT_THROW(ResidualModel().decode(level, ""), FormatError);
}

/// Half of the disk is rough: knowing where is worth more than the sum of single numbers says.
TEST(ResidualModel, BeatsTheEntropyOfSingleNumbersWhereRoughPlacesLieTogether) {
  LevelTopology level = control_of(8);
  ResidualModel model;
  double entropy_bits = 0, coded_bits = 0;
  for (int k = 0; k < 4; ++k) {
    if (k > 0) level = level.next();
    std::vector<std::int32_t> numbers;
    std::map<std::int32_t, double> counts;
    for (std::size_t i = 0; i < level.new_count(); ++i) {
      const double size = 2 * i < level.new_count() ? 6 : 0.2;
      numbers.push_back(2 * static_cast<std::int32_t>(std::lround(size * test::random().normal())));
      ++counts[numbers.back()];
    }
    for (const auto& [number, count] : counts)
      entropy_bits -= count * std::log2(count / static_cast<double>(numbers.size()));
    coded_bits += 8.0 * static_cast<double>(model.encode(level, numbers).size());
  }
  EXPECT_LT(coded_bits, 0.97 * entropy_bits);
}

TEST(ResidualModel, RefusesALevelWithoutTheOneBefore) {
  EXPECT_THROW(ResidualModel().decode(control_of(2).next(), "abc"), FormatError);
}

TEST(ResidualModel, NoiseDecodesToNumbersOrIsRefused) {
  const LevelTopology control = control_of(4), level = control.next();
  for (int i = 0; i < 300; ++i) {
    std::string bytes;
    for (int k = 0; k < 40; ++k) bytes.push_back(static_cast<char>(test::random().below(256)));
    try {
      ResidualModel model;
      model.decode(control, bytes);
      for (const std::int32_t number : model.decode(level, bytes)) EXPECT_LT(std::abs(number), 1 << 27);
    } catch (const FormatError&) {
    }
  }
}

}  // namespace
}  // namespace phiz
