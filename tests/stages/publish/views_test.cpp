#include "stages/publish/views.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using Colour = std::array<std::uint8_t, 3>;
constexpr Colour kRed = {220, 0, 0}, kGreen = {0, 220, 0}, kBlue = {0, 0, 220}, kPaper = {250, 250, 250};

ViewOptions small_view(float half_mm) {
  ViewOptions options;
  options.width = options.height = 120;
  options.frame_mm =
      Eigen::AlignedBox3f(Eigen::Vector3f::Constant(-half_mm), Eigen::Vector3f::Constant(half_mm));
  options.light = Light::kNone;
  options.use_colours = true;
  return options;
}

// A square parallel to the picture as seen from the front, facing +z.
void add_square(TriangleMesh& mesh, const Eigen::Vector3f& centre, float half, const Colour& colour) {
  const auto first = static_cast<int>(mesh.vertex_count());
  for (const auto& [x, y] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)}) {
    mesh.positions.push_back(centre + Eigen::Vector3f(half * x, half * y, 0));
    mesh.colours.push_back(colour);
  }
  mesh.triangles.emplace_back(first, first + 1, first + 2);
  mesh.triangles.emplace_back(first, first + 2, first + 3);
}

TriangleMesh coloured_balls(const std::vector<std::pair<Eigen::Vector3f, Colour>>& places) {
  TriangleMesh all;
  for (const auto& [place, colour] : places) {
    const TriangleMesh ball = test::icosphere(1);
    const auto first = static_cast<int>(all.vertex_count());
    for (const Eigen::Vector3f& p : ball.positions) {
      all.positions.push_back(place + 2 * p);
      all.colours.push_back(colour);
    }
    for (const Eigen::Vector3i& t : ball.triangles) all.triangles.emplace_back(t.array() + first);
  }
  return all;
}

int count_colour(const Image& image, const Colour& colour) {
  return static_cast<int>(std::count(image.pixels.begin(), image.pixels.end(), colour));
}

TEST(Views, CamerasSeeWhatTheirNamesSay) {
  const TriangleMesh mesh = coloured_balls({{{10, 0, 0}, kRed}, {{0, 10, 0}, kGreen}, {{0, 0, 10}, kBlue}});
  ViewOptions options = small_view(20);  // 3 pixels a mm
  const auto colour_at = [&](std::string_view camera, int x, int y) {
    options.camera = *find_camera(camera);
    return render_mesh(mesh, options).at(x, y);
  };
  EXPECT_EQ(colour_at("front", 90, 60), kRed);  // the subject's left is on the viewer's right
  EXPECT_EQ(colour_at("front", 60, 30), kGreen);
  EXPECT_EQ(colour_at("front", 60, 60), kBlue);
  EXPECT_EQ(colour_at("left", 60, 60), kRed);
  EXPECT_EQ(colour_at("left", 30, 60), kBlue);  // the face looks to the left of the picture
  EXPECT_EQ(colour_at("side", 30, 60), kBlue);
  EXPECT_EQ(colour_at("right", 90, 60), kBlue);
  EXPECT_EQ(colour_at("back", 30, 60), kRed);
  EXPECT_EQ(colour_at("top", 60, 60), kGreen);
  EXPECT_EQ(colour_at("top", 60, 90), kBlue);
  EXPECT_EQ(find_camera("sideways"), std::nullopt);
}

TEST(Views, TheFrameGivesTheScaleAtEveryAzimuth) {
  TriangleMesh mesh;
  add_square(mesh, {0, 0, 0}, 25, kRed);
  ViewOptions options = small_view(50);
  EXPECT_EQ(count_colour(render_mesh(mesh, options), kRed), 60 * 60);
  options.camera = {180, 0};
  EXPECT_EQ(count_colour(render_mesh(mesh, options), kRed), 60 * 60);
  options.camera = {60, 0};  // half as wide
  EXPECT_NEAR(count_colour(render_mesh(mesh, options), kRed), 60 * 30, 60 * 2);
}

TEST(Views, WithoutAFrameTheWholeObjectIsSeen) {
  ViewOptions options;
  options.width = 150, options.height = 110;
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    options.camera = {35, 20};
    const Image image = render_mesh(mesh, options);
    ASSERT_EQ(image.width, 150);
    ASSERT_EQ(image.height, 110);
    EXPECT_LT(count_colour(image, kPaper), 150 * 110) << name;
    for (int x = 0; x < 150; ++x) EXPECT_TRUE(image.at(x, 0) == kPaper && image.at(x, 109) == kPaper) << name;
    for (int y = 0; y < 110; ++y) EXPECT_TRUE(image.at(0, y) == kPaper && image.at(149, y) == kPaper) << name;
  }
}

TEST(Views, TheNearerSurfaceHidesTheFartherInAnyOrder) {
  for (const bool near_first : {true, false}) {
    TriangleMesh mesh;
    add_square(mesh, {0, 0, near_first ? 5.0f : -5.0f}, 20, near_first ? kRed : kBlue);
    add_square(mesh, {0, 0, near_first ? -5.0f : 5.0f}, 20, near_first ? kBlue : kRed);
    const Image image = render_mesh(mesh, small_view(30));
    EXPECT_EQ(count_colour(image, kRed), 80 * 80);
    EXPECT_EQ(count_colour(image, kBlue), 0);
  }
}

TEST(Views, WiresOfHiddenTrianglesDoNotShow) {
  TriangleMesh front, both;
  add_square(front, {0, 0, 5}, 20, kRed);
  add_square(both, {0, 0, 5}, 20, kRed);
  for (int k = -2; k <= 2; ++k) add_square(both, {4.0f * static_cast<float>(k), 1.5f, -5}, 2, kBlue);
  ViewOptions options = small_view(30);
  options.wireframe = true;
  const Image image = render_mesh(front, options);
  EXPECT_EQ(image.pixels, render_mesh(both, options).pixels);
  options.wireframe = false;
  EXPECT_NE(image.pixels, render_mesh(front, options).pixels);
}

TEST(Views, TrianglesSeenFromBehindAreTinted) {
  TriangleMesh mesh;
  add_square(mesh, {0, 0, 0}, 20, kPaper);
  ViewOptions options = small_view(30);
  options.light = Light::kSoft;
  const Colour front = render_mesh(mesh, options).at(60, 60);
  std::swap(mesh.triangles[0].x(), mesh.triangles[0].y());
  std::swap(mesh.triangles[1].x(), mesh.triangles[1].y());
  const Colour behind = render_mesh(mesh, options).at(60, 60);
  EXPECT_LE(std::abs(front[0] - front[2]), 8);
  EXPECT_GT(behind[2], behind[0] + 20);
}

TEST(Views, ASurfaceOfManyTrianglesHasNoGaps) {
  const TriangleMesh sphere = test::icosphere(5);
  ViewOptions options = small_view(1.2f);
  options.clay = kRed;
  for (const double azimuth : {0.0, 33.0, 71.0}) {
    options.camera = {azimuth, 0};
    const Image image = render_mesh(sphere, options);
    int gaps = 0;
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 120; ++x) gaps += std::hypot(x - 59.5, y - 59.5) < 48.5 && image.at(x, y) != kRed;
    EXPECT_EQ(gaps, 0) << azimuth;
  }
}

TEST(Views, HeatColoursAreThoseOfTheLegend) {
  TriangleMesh mesh;
  for (int k = 0; k < 4; ++k) add_square(mesh, {-30.0f + 20.0f * static_cast<float>(k), 0, 0}, 9, kGreen);
  ViewOptions options = small_view(45);
  options.heat = HeatMap{.values = {}, .low = 0, .high = 3, .caption = "mm"};
  for (const float value : {-1.0f, 0.0f, 3.0f, std::numeric_limits<float>::quiet_NaN()})
    for (int corner = 0; corner < 4; ++corner) options.heat->values.push_back(value);
  const Image image = render_mesh(mesh, options);
  const auto square = [&](int k) {
    return image.at(60 + static_cast<int>((-30.0 + 20.0 * k) * 60 / 45), 60);
  };
  EXPECT_GT(image.width, 120);
  EXPECT_EQ(square(0), square(1));  // beyond the end: the end's colour
  EXPECT_EQ(square(3)[0], square(3)[1]);
  EXPECT_EQ(square(3)[1], square(3)[2]);
  // The bar starts ten pixels right of the picture and is as high as half of it.
  EXPECT_NEAR(image.at(133, 60 + 29)[0], square(1)[0], 6);
  EXPECT_NEAR(image.at(133, 60 - 30)[0], square(2)[0], 6);
}

TEST(Views, SameBytesAtAnyThreadCount) {
  const TriangleMesh torus = test::torus(60, 30);
  PointCloud cloud;
  cloud.positions = torus.positions;
  const auto draw = [&](int threads) {
    std::vector<Image> images;
    with_threads(threads, [&] {
      ViewOptions options;
      options.width = 200, options.height = 150;
      options.camera = {30, 40};
      options.wireframe = true;
      images.push_back(render_mesh(torus, options));
      images.push_back(render_points(cloud, options));
      options.light = Light::kSide;
      options.flat = true;
      images.push_back(render_mesh(torus, options));
    });
    return images;
  };
  const std::vector<Image> one = draw(1), two = draw(2);
  for (std::size_t k = 0; k < one.size(); ++k) EXPECT_EQ(one[k].pixels, two[k].pixels);
}

TEST(Views, PointsOfASurfaceCoverItAndKeepTheirColours) {
  PointCloud cloud;
  for (int k = 0; k < 4000; ++k) {
    cloud.positions.emplace_back(test::random().uniform(-20, 20), test::random().uniform(-20, 20), 0.0f);
    cloud.colours.push_back(cloud.positions.back().x() < 0 ? kRed : kBlue);
  }
  const Image image = render_points(cloud, small_view(30));
  int gaps = 0, strange = 0;
  for (int y = 22; y < 98; ++y)
    for (int x = 22; x < 98; ++x) {
      gaps += image.at(x, y) == kPaper;
      strange += std::abs(x - 60) > 5 && image.at(x, y) == (x < 60 ? kBlue : kRed);
    }
  EXPECT_LE(gaps, 20);
  EXPECT_EQ(strange, 0);
}

TEST(Views, PointNormalsAreLitLikeTheMeshTheyComeFrom) {
  const TriangleMesh sphere = test::icosphere(5);
  PointCloud cloud;
  cloud.positions = cloud.normals = sphere.positions;
  ViewOptions options = small_view(1.2f);
  options.light = Light::kSide;
  const Image points = render_points(cloud, options), mesh = render_mesh(sphere, options);
  for (const auto& [x, y] : {std::pair(40, 60), std::pair(60, 60), std::pair(75, 45), std::pair(50, 80)})
    EXPECT_NEAR(points.at(x, y)[1], mesh.at(x, y)[1], 12) << x << ' ' << y;
}

TEST(Views, ReliefOfPointsWithoutNormalsIsLitLikeTheMesh) {
  const TriangleMesh sphere = test::icosphere(6);
  PointCloud cloud;
  cloud.positions = sphere.positions;
  ViewOptions options = small_view(1.2f);
  options.light = Light::kSide;
  const Image points = render_points(cloud, options), mesh = render_mesh(sphere, options);
  for (const auto& [x, y] : {std::pair(40, 60), std::pair(50, 60), std::pair(45, 45), std::pair(50, 75)})
    EXPECT_NEAR(points.at(x, y)[1], mesh.at(x, y)[1], 25) << x << ' ' << y;
}

TEST(Views, OutliersDoNotShrinkAnUnframedCloud) {
  PointCloud cloud;
  for (const Eigen::Vector3f& p : test::icosphere(5).positions) cloud.positions.push_back(100 * p);
  ViewOptions options;
  options.width = options.height = 100;
  const int before = count_colour(render_points(cloud, options), kPaper);
  for (int k = 0; k < 20; ++k) cloud.positions.emplace_back(5000, test::random().uniform(-5000, 5000), 4000);
  EXPECT_NEAR(count_colour(render_points(cloud, options), kPaper), before, 300);
}

TEST(Views, LeaveOutWhatIsNotFinite) {
  TriangleMesh mesh;
  add_square(mesh, {0, 0, 0}, 20, kRed);
  add_square(mesh, {0, 0, 5}, 20, kBlue);
  mesh.positions[4].x() = std::numeric_limits<float>::quiet_NaN();
  mesh.positions[6].y() = std::numeric_limits<float>::infinity();
  EXPECT_EQ(count_colour(render_mesh(mesh, small_view(30)), kRed), 80 * 80);
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {std::numeric_limits<float>::infinity(), 0, 0}, {3e38f, -3e38f, 3e38f}};
  EXPECT_LT(count_colour(render_points(cloud, small_view(30)), kPaper), 120 * 120);
}

TEST(Views, NothingGivesAnEmptyPicture) {
  ViewOptions options = small_view(30);
  EXPECT_EQ(count_colour(render_mesh({}, options), kPaper), 120 * 120);
  EXPECT_EQ(count_colour(render_points({}, options), kPaper), 120 * 120);
  options.frame_mm.reset();
  EXPECT_EQ(count_colour(render_mesh({}, options), kPaper), 120 * 120);
  EXPECT_EQ(count_colour(render_points({}, options), kPaper), 120 * 120);
  PointCloud one;
  one.positions = {{1, 2, 3}};
  EXPECT_EQ(render_points(one, options).width, 120);
}

TEST(Views, RefuseWhatTheyCannotDraw) {
  TriangleMesh mesh = test::tetrahedron();
  ViewOptions options = small_view(2);
  options.width = 0;
  EXPECT_THROW(render_mesh(mesh, options), InvalidInput);
  options = small_view(2);
  options.camera.azimuth_deg = std::numeric_limits<double>::infinity();
  EXPECT_THROW(render_mesh(mesh, options), InvalidInput);
  options = small_view(2);
  options.frame_mm = Eigen::AlignedBox3f();
  EXPECT_THROW(render_mesh(mesh, options), InvalidInput);
  options = small_view(2);
  options.heat = HeatMap{.values = {1, 2, 3}, .caption = "mm"};
  EXPECT_THROW(render_mesh(mesh, options), InvalidInput);
  options = small_view(2);
  mesh.triangles[0].x() = 4;
  EXPECT_THROW(render_mesh(mesh, options), InvalidInput);
}

}  // namespace
}  // namespace phiz
