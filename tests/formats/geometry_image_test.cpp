#include "formats/geometry_image.h"

#include <gtest/gtest.h>

#include <sstream>

#include "formats/error.h"
#include "formats/image.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

GeometryImage sample_image(int width, int height) {
  GeometryImage image;
  image.width = width;
  image.height = height;
  image.template_digest = "abc";
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector2d uv = image.uv(x, y);
      image.positions.emplace_back(float(40 * uv.x()), float(30 * uv.y()), float(test::random().uniform()));
      image.normals.emplace_back(0, 0, 1);
      image.colours.emplace_back(0.25f, 0.5f, 0.75f);
      image.confidences.push_back(static_cast<float>(test::random().uniform()));
      image.mask.push_back(x % 2 ? 1.0f : 0.0f);
    }
  }
  return image;
}

std::string bytes_of(const GeometryImage& image) {
  std::ostringstream out;
  write_geometry_image(image, out);
  return out.str();
}

TEST(GeometryImageFile, KeepsEveryLayerAndTheSameBytes) {
  const GeometryImage image = sample_image(7, 5);
  const std::string bytes = bytes_of(image);
  std::istringstream in(bytes);
  const GeometryImage back = read_geometry_image(in);
  EXPECT_EQ(back.width, 7);
  EXPECT_EQ(back.height, 5);
  EXPECT_EQ(back.template_digest, "abc");
  EXPECT_EQ(back.positions, image.positions);  // float, exact
  EXPECT_EQ(back.normals, image.normals);
  EXPECT_EQ(back.colours, image.colours);  // these have exact halves
  EXPECT_EQ(back.confidences, image.confidences);
  EXPECT_EQ(back.mask, image.mask);
  EXPECT_EQ(bytes_of(back), bytes);
}

TEST(GeometryImageFile, LayersMayBeMissingButPositions) {
  GeometryImage image = sample_image(4, 4);
  image.normals.clear();
  image.colours.clear();
  image.confidences.clear();
  image.mask.clear();
  std::istringstream in(bytes_of(image));
  const GeometryImage back = read_geometry_image(in);
  EXPECT_TRUE(back.normals.empty() && back.colours.empty() && back.confidences.empty() && back.mask.empty());
  image.positions.clear();
  EXPECT_THROW(bytes_of(image), FormatError);
}

TEST(GeometryImageFile, RefusesWhatIsNone) {
  FloatImage other{4, 4, {{"P.X", std::vector<float>(16)}}, {}};
  std::stringstream exr;
  write_exr(other, exr);
  EXPECT_THROW(read_geometry_image(exr), FormatError);
  GeometryImage image = sample_image(4, 4);
  image.confidences[3] = 1.5f;
  EXPECT_THROW(bytes_of(image), FormatError);
  image = sample_image(4, 4);
  image.positions[3].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(bytes_of(image), FormatError);
  image = sample_image(4, 4);
  image.mask.pop_back();
  EXPECT_THROW(bytes_of(image), FormatError);
}

TEST(GeometryImageFile, EveryTruncationIsRefused) {
  const std::string bytes = bytes_of(sample_image(6, 6));
  for (std::size_t length = 0; length < bytes.size(); length += 3) {
    std::istringstream in(bytes.substr(0, length));
    EXPECT_THROW(read_geometry_image(in), FormatError) << length;
  }
}

TEST(GeometryImageFile, GridMeshHasOneVertexANodeAndTwoTrianglesACell) {
  const GeometryImage image = sample_image(9, 6);
  const TriangleMesh mesh = make_grid_mesh(image);
  EXPECT_NO_THROW(check_mesh(mesh));
  EXPECT_EQ(mesh.positions, image.positions);
  EXPECT_EQ(mesh.triangle_count(), 2u * 8 * 5);
  double area = 0;  // counter-clockwise in (u,v), and all of the square
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector2f a = mesh.uv[t[1]] - mesh.uv[t[0]], b = mesh.uv[t[2]] - mesh.uv[t[0]];
    const double twice = a.x() * b.y() - a.y() * b.x();
    EXPECT_GT(twice, 0);
    area += twice / 2;
  }
  EXPECT_NEAR(area, 1, 1e-6);
}

TEST(GeometryImageFile, TransferFunctionGivesEveryByteBack) {
  for (int i = 0; i < 256; ++i) {
    const auto byte = static_cast<std::uint8_t>(i);
    EXPECT_EQ(srgb_from_linear(linear_from_srgb(byte)), byte);
  }
  EXPECT_EQ(linear_from_srgb(0), 0);
  EXPECT_EQ(linear_from_srgb(255), 1);
}

}  // namespace
}  // namespace phiz
