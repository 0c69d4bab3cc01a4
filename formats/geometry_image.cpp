#include "formats/geometry_image.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/error.h"
#include "formats/image.h"

namespace phiz {
namespace {

constexpr int kLargestSide = 8192;
constexpr const char* kSchema = "phiz.geometry_image.1";
constexpr const char* kUvText = "node (x,y) at u = x/(width-1), v = 1 - y/(height-1)";

void check_finite(const std::vector<Eigen::Vector3f>& rows, const char* name) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!rows[i].allFinite())
      throw FormatError(std::string(name) + " of node " + std::to_string(i) + " is not finite");
  }
}

void check_shares(const std::vector<float>& values, const char* name) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(values[i] >= 0 && values[i] <= 1))
      throw FormatError(std::string(name) + " of node " + std::to_string(i) + " is not from 0 to 1");
  }
}

void put_layer(const std::vector<Eigen::Vector3f>& rows, const std::array<const char*, 3>& names,
               FloatImage& image) {
  if (rows.empty()) return;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float>& channel = image.channels[names[axis]];
    channel.reserve(rows.size());
    for (const Eigen::Vector3f& row : rows) channel.push_back(row[axis]);
  }
}

constexpr std::array<const char*, 3> kPosition{"P.X", "P.Y", "P.Z"};
constexpr std::array<const char*, 3> kNormal{"N.X", "N.Y", "N.Z"};
constexpr std::array<const char*, 3> kColour{"Cd.R", "Cd.G", "Cd.B"};

/// Takes the three channels of a layer out of the image; none or all of them must be there.
std::vector<Eigen::Vector3f> take_layer(const std::array<const char*, 3>& names, FloatImage& image) {
  std::array<std::vector<float>, 3> channels;
  int found = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = image.channels.find(names[axis]);
    if (at == image.channels.end()) continue;
    channels[axis] = std::move(at->second);
    image.channels.erase(at);
    ++found;
  }
  if (found == 0) return {};
  if (found < 3) throw FormatError(std::string("the layer of ") + names[0] + " is not complete");
  std::vector<Eigen::Vector3f> rows(channels[0].size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = {channels[0][i], channels[1][i], channels[2][i]};
  return rows;
}

std::vector<float> take_channel(const char* name, FloatImage& image) {
  const auto at = image.channels.find(name);
  if (at == image.channels.end()) return {};
  std::vector<float> values = std::move(at->second);
  image.channels.erase(at);
  return values;
}

std::string find_attribute(const FloatImage& image, const std::string& name) {
  const auto at = image.attributes.find(name);
  return at == image.attributes.end() ? std::string() : at->second;
}

}  // namespace

void check_geometry_image(const GeometryImage& image) {
  const bool is_sized =
      image.width >= 2 && image.height >= 2 && image.width <= kLargestSide && image.height <= kLargestSide;
  if (!is_sized) throw FormatError("a geometry image has sides of 2 to 8192 nodes");
  const std::size_t count = image.node_count();
  if (image.positions.size() != count) throw FormatError("a geometry image needs one position a node");
  const auto fits = [count](std::size_t size) { return size == 0 || size == count; };
  if (!fits(image.normals.size()) || !fits(image.colours.size()) || !fits(image.confidences.size()) ||
      !fits(image.mask.size()))
    throw FormatError("a layer of the geometry image has another size");
  check_finite(image.positions, "the position");
  check_finite(image.normals, "the normal");
  check_finite(image.colours, "the colour");
  check_shares(image.confidences, "the confidence");
  check_shares(image.mask, "the mask");
}

void write_geometry_image(const GeometryImage& image, std::ostream& exr) {
  check_geometry_image(image);
  FloatImage layers;
  layers.width = image.width;
  layers.height = image.height;
  put_layer(image.positions, kPosition, layers);
  put_layer(image.normals, kNormal, layers);
  put_layer(image.colours, kColour, layers);
  if (!image.confidences.empty()) layers.channels["conf.V"] = image.confidences;
  if (!image.mask.empty()) layers.channels["mask.V"] = image.mask;
  layers.attributes = {{"phizSchema", kSchema},
                       {"phizUnit", "mm"},
                       {"phizAxes", "right-handed, +y up, +z out of the face, +x to the subject's left"},
                       {"phizUv", kUvText},
                       {"phizColour", "linear light, sRGB primaries"},
                       {"phizTemplate", image.template_digest}};
  write_exr(layers, exr);
}

GeometryImage read_geometry_image(std::istream& exr) {
  FloatImage layers = read_exr(exr);
  if (find_attribute(layers, "phizSchema") != kSchema)
    throw FormatError("the EXR is no geometry image (attribute phizSchema)",
                      "phiz export SUBJECT -o FILE.exr writes one");
  if (find_attribute(layers, "phizUnit") != "mm" || find_attribute(layers, "phizUv") != kUvText)
    throw FormatError("the geometry image has another unit or another (u,v) than this version knows");
  GeometryImage image;
  image.width = layers.width;
  image.height = layers.height;
  image.template_digest = find_attribute(layers, "phizTemplate");
  image.positions = take_layer(kPosition, layers);
  image.normals = take_layer(kNormal, layers);
  image.colours = take_layer(kColour, layers);
  image.confidences = take_channel("conf.V", layers);
  image.mask = take_channel("mask.V", layers);
  if (!layers.channels.empty())
    throw FormatError("the geometry image has an unknown layer '" + layers.channels.begin()->first + "'");
  check_geometry_image(image);
  return image;
}

TriangleMesh make_grid_mesh(const GeometryImage& image) {
  check_geometry_image(image);
  TriangleMesh mesh;
  mesh.positions = image.positions;
  mesh.normals = image.normals;
  mesh.uv.reserve(image.node_count());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) mesh.uv.push_back(image.uv(x, y).cast<float>());
  for (const Eigen::Vector3f& colour : image.colours)
    mesh.colours.push_back(
        {srgb_from_linear(colour.x()), srgb_from_linear(colour.y()), srgb_from_linear(colour.z())});
  const auto& p = image.positions;
  mesh.triangles.reserve(2 * image.node_count());
  for (int y = 0; y + 1 < image.height; ++y) {
    for (int x = 0; x + 1 < image.width; ++x) {
      const int a = (y + 1) * image.width + x, b = a + 1;                // lower left, lower right
      const int d = y * image.width + x, c = d + 1;                      // upper left, upper right
      if ((p[a] - p[c]).squaredNorm() <= (p[b] - p[d]).squaredNorm()) {  // (u,v) turns as seen from outside
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {a, c, d}});
      } else {
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {b, c, d}});
      }
    }
  }
  return mesh;
}

float linear_from_srgb(std::uint8_t value) {
  const double s = value / 255.0;
  return static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
}

std::uint8_t srgb_from_linear(float value) {
  const double l = std::clamp<double>(value, 0, 1);
  const double s = l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * s));
}

}  // namespace phiz
