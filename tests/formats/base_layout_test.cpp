#include "formats/base_layout.h"

#include <gtest/gtest.h>

#include <sstream>

#include "formats/error.h"

namespace phiz {
namespace {

const std::string kGood =
    R"({"schema":"phiz.base_layout.1","points":[{"name":"a","uv":[0,0]},{"name":"b","uv":[1,0.5]}],"edges":[["a","b"]]})";

BaseLayout read(const std::string& text) {
  std::istringstream in(text);
  return read_base_layout(in);
}

TEST(BaseLayout, ReadsPointsAndEdges) {
  const BaseLayout layout = read(kGood);
  ASSERT_EQ(layout.uv.size(), 2u);
  EXPECT_EQ(layout.uv[1], Eigen::Vector2d(1, 0.5));
  EXPECT_EQ(layout.names[0], "a");
  EXPECT_EQ(layout.edges, (std::vector<std::pair<int, int>>{{0, 1}}));
}

TEST(BaseLayout, EveryTruncationIsRefused) {
  for (std::size_t length = 0; length < kGood.size(); ++length)
    EXPECT_THROW(read(kGood.substr(0, length)), FormatError) << length;
}

TEST(BaseLayout, WhatIsWrongIsNamed) {
  const auto refused = [](const std::string& from, const std::string& to, const std::string& part) {
    std::string text = kGood;
    text.replace(text.find(from), from.size(), to);
    try {
      read(text);
      ADD_FAILURE() << "taken: " << text;
    } catch (const FormatError& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  refused("layout.1", "layout.2", "schema");
  refused("[1,0.5]", "[1,1.5]", "points 1");
  refused("[1,0.5]", "[1]", "points 1");
  refused("\"b\",\"uv\"", "\"a\",\"uv\"", "twice");
  refused("[\"a\",\"b\"]", "[\"a\",\"c\"]", "edges 0");
  refused("\"edges\"", "\"egdes\"", "egdes");
}

}  // namespace
}  // namespace phiz
