#include "stages/template/check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/stages/template/template_samples.h"

namespace phiz {
namespace {

using test::find_value;
using test::generic_head;
using test::list_short;

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// A vertex of the region off the mirror line and far from the region's own border.
int find_inner_vertex(const ControlMesh& head, const std::string& region) {
  const auto& vertices = head.annotations.regions.at(region);
  for (const int v : vertices) {
    bool inside = head.annotations.mirror[v] != v;
    for (const auto& t : head.triangles) {
      if (t[0] != v && t[1] != v && t[2] != v) continue;
      for (int k = 0; k < 3; ++k)
        inside = inside && std::binary_search(vertices.begin(), vertices.end(), t[k]);
    }
    if (inside) return v;
  }
  return -1;
}

void move_both(ControlMesh& head, int v, const Eigen::Vector3d& step) {
  head.positions[v] += step;
  const Eigen::Vector3d p = head.positions[v];
  head.positions[head.annotations.mirror[v]] = {-p[0], p[1], p[2]};
}

TEST(CheckGenericHead, OursHoldsEveryPromise) {
  const auto checks = check_generic_head(generic_head());
  EXPECT_TRUE(list_short(checks).empty()) << list_short(checks).front();
  const auto pictures = list_check_pictures();
  for (const HeadCheck& check : checks) EXPECT_TRUE(holds(pictures, check.picture)) << check.what;
}

TEST(CheckGenericHead, CatchesATurnedTriangle) {
  ControlMesh head = generic_head();
  std::swap(head.triangles[700][0], head.triangles[700][1]);
  EXPECT_TRUE(holds(list_short(check_generic_head(head)), "oriented manifold"));
}

TEST(CheckGenericHead, CatchesAHole) {
  ControlMesh head = generic_head();
  const int v = find_inner_vertex(head, "scalp");
  for (std::size_t t = 0; t < head.triangles.size(); ++t) {
    if ((head.triangles[t].array() != v).all()) continue;
    head.triangles.erase(head.triangles.begin() + static_cast<std::ptrdiff_t>(t));
    break;
  }
  EXPECT_TRUE(holds(list_short(check_generic_head(head)), "borders (the neck)"));
}

TEST(CheckGenericHead, CatchesAFoldOfTheDomain) {
  ControlMesh head = generic_head();
  const int v = find_inner_vertex(head, "forehead"), image = head.annotations.mirror[v];
  const int other = find_inner_vertex(head, "neck");
  head.uv[v] = head.uv[other];
  head.uv[image] = {1 - head.uv[v][0], head.uv[v][1]};
  const auto bad = list_short(check_generic_head(head));
  EXPECT_TRUE(holds(bad, "triangles turned over in (u,v), level 0"));
  EXPECT_TRUE(holds(bad, "triangles turned over in (u,v), level 4"));
}

TEST(CheckGenericHead, CatchesANeckLoopThatLeavesTheBorder) {
  ControlMesh head = generic_head();
  for (auto& uv : head.uv) {
    if (uv[1] == 0 && uv[0] > 0.1 && uv[0] < 0.9) uv[1] = 1e-6;
  }
  EXPECT_TRUE(holds(list_short(check_generic_head(head)),
                    "vertices on the neck loop only or on the square's border only"));
}

TEST(CheckGenericHead, CatchesASurfaceThatCrossesItself) {
  ControlMesh head = generic_head();
  move_both(head, find_inner_vertex(head, "forehead"), {0, 0, -250});
  EXPECT_TRUE(holds(list_short(check_generic_head(head)), "crossing triangles at level 4"));
}

TEST(CheckGenericHead, CatchesAsymmetry) {
  ControlMesh head = generic_head();
  head.positions[find_inner_vertex(head, "neck")][1] += 0.001;
  EXPECT_EQ(list_short(check_generic_head(head)), std::vector<std::string>{"mirror symmetry of positions"});
  head = generic_head();
  head.annotations.mirror.clear();
  EXPECT_EQ(list_short(check_generic_head(head)), std::vector<std::string>{"mirror map"});
}

TEST(CheckGenericHead, CatchesASharpTriangle) {
  ControlMesh head = generic_head();
  const int v = find_inner_vertex(head, "forehead");
  int other = -1;
  for (const auto& t : head.triangles) {
    for (int k = 0; k < 3; ++k) {
      if (t[k] == v) other = t[(k + 1) % 3];
    }
  }
  move_both(head, v, 0.95 * (head.positions[other] - head.positions[v]));
  EXPECT_TRUE(holds(list_short(check_generic_head(head)), "smallest angle of a triangle"));
}

TEST(CheckGenericHead, CatchesLoopsThatDoNotClose) {
  ControlMesh head = generic_head();
  const int v = find_inner_vertex(head, "scalp");
  std::vector<Eigen::Vector3i> around;
  for (const auto& t : head.triangles) {
    if (t[0] == v || t[1] == v || t[2] == v) around.push_back(t);
  }
  std::set<int> wings;  // two triangles that share one vertex and no neighbour
  for (const auto& t : around) {
    std::set<int> both(around[0].begin(), around[0].end());
    both.insert(t.begin(), t.end());
    const auto inside = std::count_if(around.begin(), around.end(), [&](const Eigen::Vector3i& other) {
      return std::all_of(other.begin(), other.end(), [&](int w) { return both.contains(w); });
    });
    if (both.size() == 5 && inside == 2) wings = both;
  }
  ASSERT_EQ(wings.size(), 5u);
  head.annotations.regions["eyes"] = {wings.begin(), wings.end()};
  EXPECT_TRUE(holds(list_short(check_generic_head(head)), "closed edge loops around each eye"));
}

TEST(CheckGenericHead, CatchesMissingAnnotations) {
  ControlMesh head = generic_head();
  head.annotations.landmarks.erase("chin");
  head.annotations.landmarks.erase("tragus_left");
  head.annotations.boxes.erase("nose");
  head.annotations.regions.erase("lips");
  head.annotations.clipping_planes.erase("back");
  head.annotations.constrained_vertices.clear();
  head.annotations.binding_edges.clear();
  const auto checks = check_generic_head(head);
  EXPECT_EQ(find_value(checks, "missing landmarks of the usual 68"), "chin");
  EXPECT_EQ(find_value(checks, "missing boxes"), "nose");
  EXPECT_EQ(find_value(checks, "missing clipping planes"), "back");
  const auto bad = list_short(checks);
  for (const char* what : {"missing ear landmarks (three each)", "missing regions of a human face",
                           "constrained vertices of the inner lips", "binding edges behind the ears"}) {
    EXPECT_TRUE(holds(bad, what)) << what;
  }
}

TEST(CheckGenericHead, AnAnimalNeedsNoHumanFace) {
  ControlMesh head = generic_head();
  head.annotations.landmarks.clear();
  for (const char* region : {"lips", "inner_mouth", "eyelids", "eyes", "nostrils", "nose"})
    head.annotations.regions.erase(region);
  auto& everything = head.annotations.regions["head"];
  for (int v = 0; v < static_cast<int>(head.positions.size()); ++v) everything.push_back(v);
  head.annotations.binding_edges.clear();
  const auto checks = check_generic_head(head);
  EXPECT_TRUE(list_short(checks).empty()) << list_short(checks).front();
  EXPECT_EQ(find_value(checks, "closed edge loops around each eye"), "no region 'eyes'");
  EXPECT_EQ(find_value(checks, "missing landmarks of the usual 68"), "chin nose_tip subnasale and 65 more");
}

TEST(CheckGenericHead, SaysWhatItCanOfWhatIsNoHead) {
  ControlMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.uv = {{0, 0}, {1, 0}, {0, 1}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_TRUE(holds(list_short(check_generic_head(mesh)), "vertices"));
  EXPECT_EQ(measure_head(mesh).valences, (std::vector<int>{0, 0, 0}));
  mesh.triangles.clear();
  EXPECT_TRUE(holds(list_short(check_generic_head(mesh)), "borders (the neck)"));
}

}  // namespace
}  // namespace phiz
