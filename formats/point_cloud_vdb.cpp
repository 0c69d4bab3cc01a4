#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <sstream>

#include "formats/content_seal.h"
#include "formats/error.h"
#include "formats/point_cloud.h"
#include "formats/text.h"

namespace phiz {
namespace {

namespace vp = openvdb::points;
using PositionCodec = vp::FixedPointCodec<false, vp::PositionRange>;
using ColourCodec = vp::FixedPointCodec<true, vp::UnitRange>;
using ConfidenceCodec = vp::FixedPointCodec<false, vp::UnitRange>;
using PositionAttribute = vp::TypedAttributeArray<openvdb::Vec3f, PositionCodec>;
using NormalAttribute = vp::TypedAttributeArray<openvdb::Vec3f>;
using ColourAttribute = vp::TypedAttributeArray<openvdb::Vec3f, ColourCodec>;
using ConfidenceAttribute = vp::TypedAttributeArray<float, ConfidenceCodec>;
using Leaf = vp::PointDataTree::LeafNodeType;

constexpr double kVoxelMm = 2.0;
constexpr double kLargestMm = 1e6;
constexpr std::size_t kMostPointsPerByte = 1000;  // of any file that is what it claims
constexpr std::int64_t kSteps = 65535;            // of a fixed-point number in [0,1]
constexpr double kNormalSteps = 16384.0;          // floats hold multiples of 2^-14 exactly
constexpr int kLeafBias = 1 << 16;                // leaves of 8 voxels within 1 km have 17-bit coordinates

/// A point as the file holds it. Members stand in the order that sorts points.
struct StoredPoint {
  std::uint64_t voxel = 0;  ///< leaf x, y, z (17 bits each), voxel in the leaf (9 bits)
  std::uint64_t place_and_confidence = 0;
  std::array<std::int16_t, 3> normal{};
  std::array<std::uint8_t, 3> colour{};
  auto operator<=>(const StoredPoint&) const = default;

  std::uint64_t leaf() const { return voxel >> 9; }
  std::uint64_t place(int axis) const { return place_and_confidence >> (48 - 16 * axis) & 0xffff; }
  std::uint64_t confidence() const { return place_and_confidence & 0xffff; }
};

[[noreturn]] void fail_at(const std::string& what, std::size_t point_idx) {
  throw FormatError(what + " (point " + std::to_string(point_idx) + ")");
}

void check_rows(std::size_t rows, const PointCloud& cloud, const char* name) {
  if (rows == 0 || rows == cloud.size()) return;
  throw FormatError(std::to_string(rows) + " " + name + " for " + std::to_string(cloud.size()) + " points");
}

/// Every coordinate is a step of one lattice over all voxels, so that a point on the border of two has one
/// home.
void store_position(const Eigen::Vector3f& position, StoredPoint& point) {
  std::uint64_t leaf = 0, local = 0, place = 0;
  for (float coordinate : position) {
    const std::int64_t bias = std::int64_t{8} * kLeafBias * kSteps;
    const auto step =
        static_cast<std::int64_t>(std::floor((coordinate / kVoxelMm + 0.5) * kSteps + 0.5)) + bias;
    const auto voxel = static_cast<std::uint64_t>(step / kSteps);
    leaf = leaf << 17 | voxel >> 3;
    local = local << 3 | (voxel & 7);
    place = place << 16 | static_cast<std::uint64_t>(step % kSteps);
  }
  point.voxel = leaf << 9 | local;
  point.place_and_confidence = place << 16;
}

std::vector<StoredPoint> store_points(const PointCloud& cloud) {
  std::vector<StoredPoint> points(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    StoredPoint& point = points[i];
    if (!(cloud.positions[i].cwiseAbs().maxCoeff() <= kLargestMm) || !cloud.positions[i].allFinite()) {
      fail_at("position is not finite or beyond 1 km", i);
    }
    store_position(cloud.positions[i], point);
    if (cloud.has_normals()) {
      if (!(cloud.normals[i].cwiseAbs().maxCoeff() <= 1.001f) || !cloud.normals[i].allFinite()) {
        fail_at("normal is not finite or longer than 1", i);
      }
      for (int k = 0; k < 3; ++k) {
        point.normal[k] = static_cast<std::int16_t>(std::floor(cloud.normals[i][k] * kNormalSteps + 0.5));
      }
    }
    if (cloud.has_colours()) point.colour = cloud.colours[i];
    if (cloud.has_confidences()) {
      const float confidence = cloud.confidences[i];
      if (!(confidence >= 0.0f && confidence <= 1.0f)) fail_at("confidence is not in [0,1]", i);
      point.place_and_confidence |= static_cast<std::uint64_t>(std::lround(confidence * double{kSteps}));
    }
  }
  tbb::parallel_sort(points.begin(), points.end());  // equal points are alike: the order is the only one
  return points;
}

/// OpenVDB's codecs round down: aim between two steps.
float aim(std::uint64_t step, std::int64_t steps) {
  return static_cast<float>((static_cast<double>(step) + 0.25) / static_cast<double>(steps));
}

template <typename Value, typename Codec, typename Row>
void fill(Leaf& leaf, const char* name, std::span<const StoredPoint> points, Row row) {
  vp::AttributeArray& array = leaf.attributeArray(name);
  vp::AttributeWriteHandle<Value, Codec> handle(array);
  // not compact(): it codes what it decoded, and codecs round down
  if (std::all_of(points.begin(), points.end(),
                  [&](const auto& point) { return row(point) == row(points[0]); })) {
    handle.collapse(row(points[0]));
    return;
  }
  for (std::size_t i = 0; i < points.size(); ++i) handle.set(static_cast<openvdb::Index>(i), row(points[i]));
}

vp::AttributeSet::Descriptor::Ptr make_descriptor(const PointCloud& cloud) {
  auto descriptor = vp::AttributeSet::Descriptor::create(PositionAttribute::attributeType());
  if (cloud.has_normals()) descriptor = descriptor->duplicateAppend("N", NormalAttribute::attributeType());
  if (cloud.has_colours()) descriptor = descriptor->duplicateAppend("Cd", ColourAttribute::attributeType());
  if (cloud.has_confidences()) {
    descriptor = descriptor->duplicateAppend("confidence", ConfidenceAttribute::attributeType());
  }
  return descriptor;
}

void fill_leaf(Leaf& leaf, const PointCloud& cloud, std::span<const StoredPoint> points) {
  std::vector<std::uint32_t> ends(Leaf::SIZE, 0);
  for (const StoredPoint& point : points) ++ends[point.voxel & 511];
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  leaf.setOffsets(std::vector<Leaf::ValueType>(ends.begin(), ends.end()));
  fill<openvdb::Vec3f, PositionCodec>(leaf, "P", points, [](const StoredPoint& point) {
    const auto offset = [&point](int axis) { return aim(point.place(axis), kSteps) - 0.5f; };
    return openvdb::Vec3f(offset(0), offset(1), offset(2));
  });
  if (cloud.has_normals()) {
    fill<openvdb::Vec3f, vp::NullCodec>(leaf, "N", points, [](const StoredPoint& point) {
      return openvdb::Vec3f(point.normal[0], point.normal[1], point.normal[2]) /
             static_cast<float>(kNormalSteps);
    });
  }
  if (cloud.has_colours()) {
    fill<openvdb::Vec3f, ColourCodec>(leaf, "Cd", points, [](const StoredPoint& point) {
      return openvdb::Vec3f(aim(point.colour[0], 255), aim(point.colour[1], 255), aim(point.colour[2], 255));
    });
  }
  if (cloud.has_confidences()) {
    fill<float, ConfidenceCodec>(leaf, "confidence", points,
                                 [](const StoredPoint& point) { return aim(point.confidence(), kSteps); });
  }
}

vp::PointDataGrid::Ptr make_grid(const PointCloud& cloud) {
  const std::vector<StoredPoint> points = store_points(cloud);
  const auto grid = vp::PointDataGrid::create();
  grid->setName("points");
  grid->setTransform(openvdb::math::Transform::createLinearTransform(kVoxelMm));
  grid->insertMeta("length_unit", openvdb::StringMetadata("mm"));
  struct Share {
    Leaf* leaf;
    std::size_t begin, end;
  };
  std::vector<Share> shares;
  for (std::size_t begin = 0, end = 0; begin < points.size(); begin = end) {
    const std::uint64_t key = points[begin].leaf();
    while (end < points.size() && points[end].leaf() == key) ++end;
    const auto corner = [key](int axis) {
      return 8 * (static_cast<int>(key >> (34 - 17 * axis) & 0x1ffff) - kLeafBias);
    };
    shares.push_back({grid->tree().touchLeaf(openvdb::Coord(corner(0), corner(1), corner(2))), begin, end});
  }
  const auto descriptor = make_descriptor(cloud);
  tbb::parallel_for(std::size_t{0}, shares.size(), [&](std::size_t i) {
    const auto& [leaf, begin, end] = shares[i];
    const auto count = static_cast<openvdb::Index>(end - begin);
    leaf->replaceAttributeSet(new vp::AttributeSet(descriptor, count), true);
    fill_leaf(*leaf, cloud, std::span(points).subspan(begin, count));
  });
  return grid;
}

/// OpenVDB's own file writer wants a path; its archive can write to memory in the same layout.
struct MemoryArchive : openvdb::io::Archive {
  void write_grid(const openvdb::GridBase::Ptr& grid, std::ostream& out) const {
    Archive::write(out, openvdb::GridPtrVec{grid}, true);
  }
};

// ---- reading

/// Into [0,1]; no number becomes 0.
float to_unit(float value) {
  return value > 0.0f ? std::min(value, 1.0f) : 0.0f;
}

/// One attribute of a leaf, absent or with a value per point.
template <typename Value>
std::optional<vp::AttributeHandle<Value>> find_attribute(const Leaf& leaf, const char* name) {
  if (!leaf.hasAttribute(name)) return std::nullopt;
  const vp::AttributeArray& array = leaf.constAttributeArray(name);
  if (!array.hasValueType<Value>()) return std::nullopt;
  if (array.size() != leaf.constAttributeArray("P").size() || array.stride() != 1) {
    throw FormatError(std::string("broken attribute `") + name + "`");
  }
  return vp::AttributeHandle<Value>(array);
}

/// Decodes the points of a leaf into rows from `row` on.
void read_positions(const Leaf& leaf, const openvdb::math::Transform& transform, Eigen::Vector3f* row) {
  const auto place = find_attribute<openvdb::Vec3f>(leaf, "P");
  if (!place) throw FormatError("positions `P` are no Vec3f");
  const bool is_fixed = leaf.constAttributeArray("P").type() == PositionAttribute::attributeType();
  openvdb::Index i = 0;
  for (openvdb::Index voxel = 0; voxel < Leaf::SIZE; ++voxel) {
    const openvdb::Index end = leaf.getValue(voxel);
    if (end < i || end > place->size()) throw FormatError("broken point offsets");
    const openvdb::Vec3d centre = leaf.offsetToGlobalCoord(voxel).asVec3d();
    for (; i < end; ++i) {
      openvdb::Vec3d offset(place->get(i));
      for (int k = 0; is_fixed && k < 3; ++k) {  // the float is a little off its step
        offset[k] = static_cast<int>((offset[k] + 0.5) * kSteps + 0.5) / static_cast<double>(kSteps) - 0.5;
      }
      const openvdb::Vec3d world = transform.indexToWorld(centre + offset);
      *row++ = Eigen::Vector3d(world.x(), world.y(), world.z()).cast<float>();
    }
  }
  if (i != place->size()) throw FormatError("broken point offsets");
}

void read_attributes(const Leaf& leaf, std::size_t first_row, PointCloud& cloud) {
  const auto normal = find_attribute<openvdb::Vec3f>(leaf, "N");
  const auto colour = find_attribute<openvdb::Vec3f>(leaf, "Cd");
  const auto confidence = find_attribute<float>(leaf, "confidence");
  if (cloud.has_normals() != bool{normal} || cloud.has_colours() != bool{colour} ||
      cloud.has_confidences() != bool{confidence}) {
    throw FormatError("some points have attributes that others lack");
  }
  const openvdb::Index count = leaf.constAttributeArray("P").size();
  for (openvdb::Index i = 0; i < count; ++i) {
    if (normal) cloud.normals[first_row + i] = Eigen::Vector3f(normal->get(i).asPointer());
    if (confidence) cloud.confidences[first_row + i] = to_unit(confidence->get(i));
    if (!colour) continue;
    const openvdb::Vec3f share = colour->get(i);
    for (int k = 0; k < 3; ++k) {
      cloud.colours[first_row + i][k] = static_cast<std::uint8_t>(to_unit(share[k]) * 255.0f + 0.5f);
    }
  }
}

PointCloud read_grid(const vp::PointDataGrid& grid, std::size_t file_bytes) {
  std::vector<const Leaf*> leaves;
  std::vector<std::size_t> first_rows{0};
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    if (!leaf->hasAttribute("P")) throw FormatError("points have no position `P`");
    leaves.push_back(leaf.getLeaf());
    first_rows.push_back(first_rows.back() + leaf->constAttributeArray("P").size());
  }
  if (first_rows.back() / kMostPointsPerByte > file_bytes) {
    throw FormatError("claims " + std::to_string(first_rows.back()) + " points");
  }
  PointCloud cloud;
  if (leaves.empty()) return cloud;
  cloud.positions.resize(first_rows.back());
  if (find_attribute<openvdb::Vec3f>(*leaves[0], "N")) cloud.normals.resize(cloud.size());
  if (find_attribute<openvdb::Vec3f>(*leaves[0], "Cd")) cloud.colours.resize(cloud.size());
  if (find_attribute<float>(*leaves[0], "confidence")) cloud.confidences.resize(cloud.size());
  tbb::parallel_for(std::size_t{0}, leaves.size(), [&](std::size_t i) {
    read_positions(*leaves[i], grid.transform(), cloud.positions.data() + first_rows[i]);
    read_attributes(*leaves[i], first_rows[i], cloud);
  });
  return cloud;
}

PointCloud parse(std::string bytes) {
  openvdb::initialize();
  const std::size_t file_bytes = bytes.size();
  std::istringstream stream(std::move(bytes));
  // OpenVDB does not look whether it could read, and its delayed loading crashes on broken files
  stream.exceptions(std::ios::failbit | std::ios::badbit);
  openvdb::io::Stream archive(stream, false);
  for (const openvdb::GridBase::Ptr& grid : *archive.getGrids()) {
    if (grid && grid->isType<vp::PointDataGrid>())
      return read_grid(static_cast<const vp::PointDataGrid&>(*grid), file_bytes);
  }
  throw FormatError("has no points grid");
}

}  // namespace

void write_vdb(const PointCloud& cloud, std::ostream& out) {
  check_rows(cloud.normals.size(), cloud, "normals");
  check_rows(cloud.colours.size(), cloud, "colours");
  check_rows(cloud.confidences.size(), cloud, "confidences");
  std::string bytes;
  try {
    openvdb::initialize();
    std::ostringstream stream;
    MemoryArchive().write_grid(make_grid(cloud), stream);
    bytes = std::move(stream).str();
  } catch (const openvdb::Exception& error) {
    throw FormatError(std::string("OpenVDB cannot write: ") + error.what());
  }
  seal_vdb(bytes);
  write_all(out, bytes);
}

PointCloud read_vdb_points(std::istream& in) {
  std::string bytes = read_all(in);
  check_vdb_seal(bytes);
  try {
    return parse(std::move(bytes));
  } catch (const FormatError&) {
    throw;
  } catch (const std::ios_base::failure&) {
    throw FormatError("is no OpenVDB file, or is cut short or damaged");
  } catch (const std::exception& error) {  // also out of memory and what its codecs throw
    throw FormatError(std::string("OpenVDB cannot read: ") + error.what());
  }
}

}  // namespace phiz
