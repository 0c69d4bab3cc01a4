#include "stages/template/layout.h"

#include <gtest/gtest.h>

#include "formats/error.h"
#include "tests/formats/hostile_bytes.h"
#include "tests/stages/template/template_samples.h"

namespace phiz {
namespace {

using test::generic_layout_text;
using test::small_layout_text;
using test::to_layout;

/// The text of the FormatError that the layout is refused with; empty if it is taken.
std::string refusal(const std::string& text) {
  try {
    to_layout(text);
  } catch (const FormatError& error) {
    return error.what();
  }
  return {};
}

bool names_a_line(const std::string& text) {
  return text.find("(line ") != std::string::npos;
}

TEST(Layout, HoldsWhatWasWritten) {
  const Layout layout = to_layout(small_layout_text());
  ASSERT_EQ(layout.points.size(), 9u);
  EXPECT_EQ(layout.points[0].name, "throat");
  EXPECT_EQ(layout.points[0].line, 2);
  EXPECT_TRUE(layout.points[2].name.empty());
  EXPECT_EQ(layout.points[5].uv, Eigen::Vector2d(0.2, 0.3));
  EXPECT_TRUE(layout.points[5].held);
  EXPECT_FALSE(layout.points[4].held) << "points of a flow may move";
  ASSERT_EQ(layout.curves.size(), 2u);
  EXPECT_TRUE(layout.curves[0].closed);
  EXPECT_EQ(layout.curves[0].points, (std::vector<int>{5, 6, 7}));
  EXPECT_EQ(layout.curves[0].corner, (std::vector<bool>{true, false, false}));
  ASSERT_EQ(layout.edges.size(), 1u);
  EXPECT_EQ(layout.edges[0], std::make_pair(7, 8));
  ASSERT_EQ(layout.regions.size(), 2u);
  EXPECT_EQ(layout.regions[0].left, "eye_left");
  EXPECT_EQ(layout.regions[1].left, "skin");
  EXPECT_EQ(layout.regions[1].including, std::vector<std::string>{"eye_right"});
  EXPECT_EQ(layout.constrained_regions, std::vector<std::string>{"eye_right"});
  EXPECT_EQ(layout.constrained_curves, std::vector<std::string>{"eye"});
  EXPECT_EQ(layout.planes.at("neck").offset_mm, -80);
  ASSERT_EQ(layout.scales.size(), 1u);
}

TEST(Layout, RefusesWhatItDoesNotUnderstandAndNamesTheLine) {
  const std::string text = "point a 0.1 0.1\npoint b 0.2 0.1\npoint c 0.2 0.2\n";
  for (const char* line : {"bend a b",
                           "point d 0.1",
                           "point d x 0.1",
                           "point d nan 0.1",
                           "point d 1e9 0.1",
                           "point d 0.6 0.1",
                           "point d 0.1 -0.1",
                           "point a 0.3 0.3",
                           "point d 0.1 0.1",
                           "curve k a",
                           "curve k closed a b",
                           "curve k a b a",
                           "curve k a nobody",
                           "edge a a",
                           "edge a nobody",
                           "region r",
                           "region r at 0.1 0.1 within k",
                           "region r also q",
                           "region r at 0.1",
                           "region r/s at 0.1 0.1",
                           "landmark l 0.1",
                           "landmark l m n 0.1 0.1",
                           "box b nothing 2",
                           "bind a a",
                           "bind a d",
                           "constrain nothing",
                           "plane neck 0 0 1",
                           "plane neck 1 0",
                           "scale -1 0 0 0 1 2",
                           "scale 1 0 0 0 2 1"}) {
    const std::string what = refusal(text + line + "\n");
    EXPECT_TRUE(what.find("(line 4)") != std::string::npos) << line << ": " << what;
  }
}

TEST(Layout, CommentsAndEmptyLinesSayNothing) {
  EXPECT_EQ(to_layout("\n# a\n  point a 0 0 # b\n\n").points.size(), 1u);
  EXPECT_TRUE(names_a_line(refusal("")));
  EXPECT_TRUE(names_a_line(refusal("# nothing\n")));
}

TEST(Layout, EveryPrefixIsALayoutOrRefusedWithItsLine) {
  const std::string text = small_layout_text();
  for (std::size_t length = 0; length < text.size(); ++length) {
    const std::string what = refusal(text.substr(0, length));
    EXPECT_TRUE(what.empty() || names_a_line(what)) << length << ": " << what;
  }
  const std::string whole = generic_layout_text();
  for (std::size_t length = 0; length < whole.size(); length += 97) {
    const std::string what = refusal(whole.substr(0, length));
    EXPECT_TRUE(what.empty() || names_a_line(what)) << length << ": " << what;
  }
}

TEST(Layout, SurvivesMutations) {
  test::expect_mutations_survived(small_layout_text(), 3000, [](const std::string& text) {
    const std::string what = refusal(text);
    EXPECT_TRUE(what.empty() || names_a_line(what)) << what;
  });
  EXPECT_TRUE(names_a_line(refusal("point a 0 0\n" + std::string(1 << 17, 'x'))));
}

}  // namespace
}  // namespace phiz
