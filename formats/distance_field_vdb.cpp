#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/SignedFloodFill.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "formats/content_seal.h"
#include "formats/distance_field.h"
#include "formats/error.h"
#include "formats/text.h"

namespace phiz {
namespace {

constexpr int kLargestCoordinate = 1 << 20;
constexpr double kLargestMm = 1e6;

bool precedes(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

/// Holds for what is written and for what was read.
void check_field(const DistanceField& field) {
  const bool framed = field.voxel_mm > 0.0 && field.voxel_mm <= kLargestMm && field.truncation_mm > 0.0 &&
                      field.truncation_mm <= kLargestMm && field.origin_mm.allFinite() &&
                      field.origin_mm.cwiseAbs().maxCoeff() <= kLargestMm;
  if (!framed) throw FormatError("voxel, truncation or origin of the distance field is out of range");
  const std::size_t count = field.coordinates.size();
  if (field.distances_mm.size() != count || field.confidences.size() != count) {
    throw FormatError(std::to_string(field.distances_mm.size()) + " distances and " +
                      std::to_string(field.confidences.size()) + " confidences for " + std::to_string(count) +
                      " coordinates");
  }
  const auto fail_at = [](const char* what, std::size_t i) {
    throw FormatError(std::string(what) + " (sample " + std::to_string(i) + ")");
  };
  for (std::size_t i = 0; i < count; ++i) {
    if (field.coordinates[i].minCoeff() < -kLargestCoordinate ||
        field.coordinates[i].maxCoeff() > kLargestCoordinate) {
      fail_at("coordinate is beyond 2^20", i);
    }
    if (i > 0 && !precedes(field.coordinates[i - 1], field.coordinates[i]))
      fail_at("coordinates do not ascend", i);
    if (!(std::abs(field.distances_mm[i]) <= static_cast<float>(field.truncation_mm))) {
      fail_at("distance is beyond the truncation", i);
    }
    if (!(field.confidences[i] >= 0.0f && field.confidences[i] <= 1.0f))
      fail_at("confidence is not in [0,1]", i);
  }
}

openvdb::FloatGrid::Ptr make_grid(const DistanceField& field, const char* name,
                                  const std::vector<float>& values, double background) {
  const auto grid = openvdb::FloatGrid::create(static_cast<float>(background));
  grid->setName(name);
  const auto transform = openvdb::math::Transform::createLinearTransform(field.voxel_mm);
  transform->postTranslate(openvdb::Vec3d(field.origin_mm.x(), field.origin_mm.y(), field.origin_mm.z()));
  grid->setTransform(transform);
  grid->insertMeta("length_unit", openvdb::StringMetadata("mm"));
  grid->insertMeta("axes", openvdb::StringMetadata("right-handed, +y up, +z out of the face"));
  openvdb::FloatGrid::Accessor accessor = grid->getAccessor();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Eigen::Vector3i& at = field.coordinates[i];
    accessor.setValueOn(openvdb::Coord(at.x(), at.y(), at.z()), values[i]);
  }
  return grid;
}

/// OpenVDB's own file writer wants a path; its archive can write to memory in the same layout.
struct MemoryArchive : openvdb::io::Archive {
  void write_grids(const openvdb::GridPtrVec& grids, std::ostream& out) const {
    Archive::write(out, grids, true);
  }
};

std::string encode(const DistanceField& field) {
  openvdb::initialize();
  const auto surface = make_grid(field, "surface", field.distances_mm, field.truncation_mm);
  surface->setGridClass(openvdb::GRID_LEVEL_SET);
  surface->insertMeta("voxel_mm", openvdb::DoubleMetadata(field.voxel_mm));
  surface->insertMeta("truncation_mm", openvdb::DoubleMetadata(field.truncation_mm));
  openvdb::tools::signedFloodFill(surface->tree());  // for other programs: the inside is inside
  const auto confidence = make_grid(field, "confidence", field.confidences, 0.0);
  std::ostringstream stream;
  MemoryArchive().write_grids({surface, confidence}, stream);
  return std::move(stream).str();
}

openvdb::FloatGrid::Ptr find_grid(const openvdb::GridPtrVec& grids, const char* name) {
  for (const openvdb::GridBase::Ptr& grid : grids) {
    if (grid && grid->getName() == name && grid->isType<openvdb::FloatGrid>()) {
      return openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
    }
  }
  throw FormatError(std::string("has no float grid `") + name + "`");
}

struct Sample {
  Eigen::Vector3i at;
  float value;
};

std::vector<Sample> sorted_samples(const openvdb::FloatGrid& grid) {
  std::vector<Sample> samples;
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    for (auto voxel = leaf->cbeginValueOn(); voxel; ++voxel) {
      const openvdb::Coord at = voxel.getCoord();
      samples.push_back({Eigen::Vector3i(at.x(), at.y(), at.z()), *voxel});
    }
  }
  std::sort(samples.begin(), samples.end(),
            [](const auto& a, const auto& b) { return precedes(a.at, b.at); });
  return samples;
}

DistanceField decode(std::string bytes) {
  openvdb::initialize();
  std::istringstream stream(std::move(bytes));
  // OpenVDB does not look whether it could read, and its delayed loading crashes on broken files
  stream.exceptions(std::ios::failbit | std::ios::badbit);
  openvdb::io::Stream archive(stream, false);
  const openvdb::GridPtrVecPtr grids = archive.getGrids();
  const auto surface = find_grid(*grids, "surface"), confidence = find_grid(*grids, "confidence");
  DistanceField field;
  field.voxel_mm = surface->metaValue<double>("voxel_mm");
  field.truncation_mm = surface->metaValue<double>("truncation_mm");
  const openvdb::Vec3d origin = surface->indexToWorld(openvdb::Vec3d(0.0));
  field.origin_mm = Eigen::Vector3d(origin.x(), origin.y(), origin.z());
  const std::vector<Sample> distances = sorted_samples(*surface), trust = sorted_samples(*confidence);
  const bool paired = std::equal(distances.begin(), distances.end(), trust.begin(), trust.end(),
                                 [](const Sample& a, const Sample& b) { return a.at == b.at; });
  if (!paired) throw FormatError("`surface` and `confidence` have different voxels");
  for (const Sample& sample : distances) {
    field.coordinates.push_back(sample.at);
    field.distances_mm.push_back(sample.value);
  }
  for (const Sample& sample : trust) field.confidences.push_back(sample.value);
  check_field(field);
  return field;
}

}  // namespace

void write_vdb(const DistanceField& field, std::ostream& out) {
  check_field(field);
  std::string bytes;
  try {
    bytes = encode(field);
  } catch (const openvdb::Exception& error) {
    throw FormatError(std::string("OpenVDB cannot write: ") + error.what());
  }
  seal_vdb(bytes);
  write_all(out, bytes);
}

DistanceField read_vdb_distance_field(std::istream& in) {
  std::string bytes = read_all(in);
  check_vdb_seal(bytes);
  try {
    return decode(std::move(bytes));
  } catch (const FormatError&) {
    throw;
  } catch (const std::exception& error) {  // also out of memory and what its codecs throw
    throw FormatError(std::string("OpenVDB cannot read: ") + error.what());
  }
}

}  // namespace phiz
