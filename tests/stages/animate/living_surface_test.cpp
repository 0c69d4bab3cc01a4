#include "stages/animate/living_surface.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "formats/control_mesh.h"
#include "stages/geometry/error.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using Points = std::vector<Eigen::Vector3f>;

/// A mesh of about 100 mm with displacements on every level, and its hierarchy.
struct Subject {
  Subject(const TriangleMesh& mesh, int levels, double scale = 100)
      : hierarchy(mesh.triangles, static_cast<int>(mesh.vertex_count()), levels),
        plan(std::make_shared<SurfacePlan>(hierarchy)) {
    test::Random& random = test::random();
    for (const Eigen::Vector3f& p : mesh.positions) control.push_back(static_cast<float>(scale) * p);
    for (int k = 0; k <= levels; ++k) {
      displacements.emplace_back(hierarchy.vertex_count(k), 0.0f);
      const int first = k == 0 ? 0 : hierarchy.vertex_count(k - 1);
      for (int v = first; v < hierarchy.vertex_count(k); ++v)
        displacements.back()[v] = static_cast<float>(random.normal() * std::pow(0.4, k));
    }
  }
  std::vector<Eigen::Vector3d> reference(int level) const {
    std::vector<Eigen::Vector3d> positions;
    for (const Eigen::Vector3f& p : control) positions.push_back(p.cast<double>());
    return evaluate_surface(hierarchy, positions, displacements, level);
  }
  Eigen::Vector3f shake(int vertex, double mm) {
    test::Random& random = test::random();
    for (int i = 0; i < 3; ++i) control[vertex][i] += static_cast<float>(mm * random.normal());
    return control[vertex];
  }

  SubdivisionHierarchy hierarchy;
  std::shared_ptr<const SurfacePlan> plan;
  Points control;
  std::vector<std::vector<float>> displacements;
};

double largest_distance(std::span<const Point4> points, const std::vector<Eigen::Vector3d>& reference) {
  EXPECT_EQ(points.size(), reference.size());
  double largest = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    largest =
        std::max(largest, (Eigen::Vector3d(points[i].x, points[i].y, points[i].z) - reference[i]).norm());
  return largest;
}

bool same_bits(std::span<const Point4> a, std::span<const Point4> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

TriangleMesh load_generic_head() {
  const std::string folder = PHIZ_SOURCE_FOLDER "/samples/generic_head/";
  std::ifstream obj(folder + "head.obj"), json(folder + "head.json");
  const ControlMesh head = read_control_mesh(obj, json);
  TriangleMesh mesh;
  for (const Eigen::Vector3d& p : head.positions) mesh.positions.push_back(p.cast<float>());
  mesh.triangles = head.triangles;
  return mesh;
}

TEST(LivingSurface, IsEvaluateSurfaceInFloatOnEveryMesh) {
  for (const test::NamedMesh& named : test::mesh_zoo()) {
    if (named.name.find("sliver") != std::string::npos) continue;  // normals without a meaning
    for (int level = 0; level <= 3; ++level) {
      Subject subject(named.mesh, level);
      LivingSurface surface(subject.plan, subject.displacements);
      surface.evaluate(subject.control, level);
      EXPECT_LT(largest_distance(surface.positions(), subject.reference(level)), 1e-3)
          << named.name << " level " << level;
    }
  }
}

TEST(LivingSurface, IsEvaluateSurfaceInFloatOnTheGenericHead) {
  Subject subject(load_generic_head(), 3, 1);
  for (std::vector<float>& level : subject.displacements)
    for (float& displacement : level) displacement *= 0.3f;
  LivingSurface surface(subject.plan, subject.displacements);
  for (int v = 0; v < 100; ++v) subject.shake(static_cast<int>(test::random().below(1000)), 0.2);
  surface.evaluate(subject.control, 3);
  EXPECT_LT(largest_distance(surface.positions(), subject.reference(3)), 1e-3);
}

TEST(LivingSurface, LocalEqualsWholeBitForBit) {
  for (const test::NamedMesh& named : test::mesh_zoo()) {
    Subject subject(named.mesh, 3);
    LivingSurface local(subject.plan, subject.displacements), whole(subject.plan, subject.displacements);
    local.evaluate(subject.control, 3);
    for (int edit = 0; edit < 12; ++edit) {
      const int count = 1 + static_cast<int>(test::random().below(2));
      for (int i = 0; i < count; ++i) {
        const int vertex = static_cast<int>(test::random().below(subject.control.size()));
        local.move(vertex, subject.shake(vertex, 2));
      }
      const int level = edit % 2 == 0 ? 3 : static_cast<int>(test::random().below(4));
      local.refresh(level);
      whole.evaluate(subject.control, level);
      ASSERT_TRUE(same_bits(local.positions(), whole.positions())) << named.name << " edit " << edit;
    }
  }
}

TEST(LivingSurface, LocalEqualsWholeOnTheGenericHead) {
  Subject subject(load_generic_head(), 2, 1);
  for (const bool has_displacements : {true, false}) {
    if (!has_displacements) subject.displacements[1].clear();  // a level without any
    LivingSurface local(subject.plan, subject.displacements), whole(subject.plan, subject.displacements);
    local.evaluate(subject.control, 2);
    for (int edit = 0; edit < 40; ++edit) {
      const int vertex = static_cast<int>(test::random().below(subject.control.size()));
      local.move(vertex, subject.shake(vertex, 1));
      local.refresh(2);
      whole.evaluate(subject.control, 2);
      ASSERT_TRUE(same_bits(local.positions(), whole.positions())) << edit;
    }
  }
}

TEST(LivingSurface, OneVertexMovesOnlyItsSupport) {
  Subject subject(load_generic_head(), 3, 1);
  LivingSurface surface(subject.plan, subject.displacements);
  surface.evaluate(subject.control, 3);
  surface.move(700, subject.shake(700, 1));
  surface.refresh(3);
  EXPECT_GT(surface.updated_count(), 0);
  EXPECT_LT(surface.updated_count(), subject.hierarchy.vertex_count(3) / 8);
  surface.refresh(3);
  EXPECT_EQ(surface.updated_count(), 0);
}

TEST(LivingSurface, CoarserAndFinerFramesMayAlternate) {
  Subject subject(test::icosphere(2), 3);
  LivingSurface local(subject.plan, subject.displacements), whole(subject.plan, subject.displacements);
  local.evaluate(subject.control, 3);
  for (const int level : {1, 3, 0, 2, 2, 3, 3}) {
    local.move(5, subject.shake(5, 1));
    local.refresh(level);
    whole.evaluate(subject.control, level);
    EXPECT_EQ(local.level(), level);
    ASSERT_TRUE(same_bits(local.positions(), whole.positions())) << level;
  }
}

TEST(LivingSurface, RefusesDisplacementsOfAnotherMesh) {
  Subject subject(test::icosphere(1), 1);
  subject.displacements[1].pop_back();
  EXPECT_THROW(LivingSurface(subject.plan, subject.displacements), InvalidInput);
}

TEST(LevelChooser, TakesTheFinestLevelThatFits) {
  LevelChooser chooser(4);
  EXPECT_EQ(chooser.choose(1), 0) << "nothing is known";
  chooser.record(1, 1e-4);
  EXPECT_EQ(chooser.choose(1e-3), 2) << "4e-4 expected there, 1.6e-3 a level finer";
  chooser.record(2, 5e-3);
  EXPECT_EQ(chooser.choose(1e-3), 1);
  EXPECT_EQ(chooser.choose(1e-6), 0);
  for (int i = 0; i < 100; ++i) chooser.record(2, 1e-4);
  EXPECT_EQ(chooser.choose(1e-3), 3);
}

}  // namespace
}  // namespace phiz
