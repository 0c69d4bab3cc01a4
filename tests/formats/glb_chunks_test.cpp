#include "formats/glb_chunks.h"

#include <gtest/gtest.h>

#include "tests/formats/hostile_bytes.h"

namespace phiz {
namespace {

TEST(GlbChunks, SplitWhatWasJoined) {
  const std::string bytes = join_glb("{\"a\":1}", "bin");
  EXPECT_EQ(bytes.size() % 4, 0u);
  EXPECT_EQ(split_glb(bytes).json, "{\"a\":1} ");
  EXPECT_EQ(split_glb(bytes).bin, std::string_view("bin\0", 4));
  test::expect_prefixes_refused(bytes, 1, [](const std::string& text) { split_glb(text); });
  test::expect_mutations_survived(bytes, 5000, [](const std::string& text) { split_glb(text); });
}

}  // namespace
}  // namespace phiz
