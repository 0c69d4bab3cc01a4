#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "tests/support/random.h"

namespace {

/// Reseeds the tests' generator before each test and names the seed beside each failure.
class Reseed : public testing::EmptyTestEventListener {
  void OnTestProgramStart(const testing::UnitTest&) override {
    std::printf("PHIZ_TEST_SEED=%llu\n", static_cast<unsigned long long>(phiz::test::base_seed()));
  }
  void OnTestStart(const testing::TestInfo& info) override {
    const std::string name = std::string(info.test_suite_name()) + "." + info.name();
    phiz::test::random() = phiz::test::Random(phiz::test::seed_of_test(name));
  }
  void OnTestEnd(const testing::TestInfo& info) override {
    if (info.result()->Failed())
      std::fprintf(stderr, "seed: PHIZ_TEST_SEED=%llu\n",
                   static_cast<unsigned long long>(phiz::test::base_seed()));
  }
};

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  testing::UnitTest::GetInstance()->listeners().Append(new Reseed);
  return RUN_ALL_TESTS();
}
