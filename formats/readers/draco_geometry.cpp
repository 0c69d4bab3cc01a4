#include "formats/readers/draco_geometry.h"

#include <draco/compression/decode.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>

#include <exception>
#include <limits>
#include <string>

#include "formats/readers/byte_order.h"
#include "formats/readers/cloud_builder.h"
#include "formats/readers/fail.h"

namespace phiz::readers {
namespace {

constexpr std::size_t kHeaderBytes = 11;
constexpr std::uint64_t kMaxPointsPerByte = 256;

struct Counts {
  std::uint64_t points = 0, faces = 0;
};

/// What the stream announces, read as Draco's decoders do (bitstream 2.2 for meshes; any for point clouds),
/// because they allocate by it.
class StreamHead {
 public:
  StreamHead(std::span<const std::byte> stream, std::size_t file_byte) : file_byte_(file_byte) {
    if (stream.size() < kHeaderBytes) fail("the Draco header is cut", kHintCut);
    major_ = load<std::uint8_t>(stream.data() + 5);
    minor_ = load<std::uint8_t>(stream.data() + 6);
    is_mesh_ = load<std::uint8_t>(stream.data() + 7) == draco::TRIANGULAR_MESH;
    method_ = load<std::uint8_t>(stream.data() + 8);
    const bool has_metadata = load<std::uint16_t>(stream.data() + 9) & METADATA_FLAG_MASK;
    if (is_mesh_ && version() < DRACO_BITSTREAM_VERSION(2, 2))
      fail("is Draco of " + std::to_string(major_) + "." + std::to_string(minor_) + ", older than 2.2",
           "encode it again with a current Draco");
    buffer_.Init(reinterpret_cast<const char*>(stream.data()) + kHeaderBytes, stream.size() - kHeaderBytes);
    buffer_.set_bitstream_version(version());
    if (has_metadata) {
      draco::GeometryMetadata ignored;
      if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer_, &ignored))
        fail("the Draco metadata is damaged", kHintDamaged);
    }
  }

  Counts counts() {
    Counts counts;
    if (!is_mesh_) {
      counts.points = plain();
    } else if (method_ == draco::MESH_SEQUENTIAL_ENCODING) {
      counts.faces = varint();
      counts.points = varint();
    } else {
      buffer_.Advance(1);  // kind of traversal
      counts.points = varint();
      counts.faces = varint();
    }
    return counts;
  }

 private:
  std::uint16_t version() const { return DRACO_BITSTREAM_VERSION(major_, minor_); }

  std::uint32_t varint() {
    std::uint32_t value = 0;
    if (!draco::DecodeVarint(&value, &buffer_)) fail("the Draco header is cut", kHintCut);
    return value;
  }

  std::uint32_t plain() {
    std::uint32_t value = 0;
    if (!buffer_.Decode(&value)) fail("the Draco header is cut", kHintCut);
    return value;
  }

  [[noreturn]] void fail(const std::string& fault, const std::string& hint) const {
    fail_at_byte(fault, file_byte_, hint);
  }

  std::size_t file_byte_;
  draco::DecoderBuffer buffer_;
  int major_ = 0, minor_ = 0, method_ = 0;
  bool is_mesh_ = false;
};

}  // namespace

struct DracoGeometry::Decoded {
  std::unique_ptr<draco::PointCloud> cloud;
  const draco::Mesh* mesh = nullptr;  ///< `cloud` if it is one
  const draco::PointAttribute* position = nullptr;
  const draco::PointAttribute* normal = nullptr;
  const draco::PointAttribute* colour = nullptr;
};

namespace {

std::unique_ptr<draco::PointCloud> decode(std::span<const std::byte> stream, std::size_t file_byte) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  try {
    draco::Decoder decoder;
    auto result = decoder.DecodePointCloudFromBuffer(&buffer);
    if (result.ok()) return std::move(result).value();
    fail_at_byte("Draco cannot decode it: " + result.status().error_msg_string(), file_byte, kHintDamaged);
  } catch (const FormatError&) {
    throw;
  } catch (const std::exception& error) {  // a damaged length: bad_alloc, length_error
    fail_at_byte(std::string("Draco cannot decode it: ") + error.what(), file_byte, kHintDamaged);
  }
}

/// Null if there is none, or none that can be used.
const draco::PointAttribute* find_attribute(const draco::PointCloud& cloud, int unique_id,
                                            draco::GeometryAttribute::Type kind) {
  const draco::PointAttribute* attribute =
      unique_id >= 0 ? cloud.GetAttributeByUniqueId(static_cast<std::uint32_t>(unique_id))
                     : cloud.GetNamedAttribute(kind);
  if (!attribute || attribute->num_components() < 3) return nullptr;
  const draco::DataType type = attribute->data_type();
  return type > draco::DT_INVALID && type < draco::DT_BOOL ? attribute : nullptr;
}

/// True if the value of each point lies within the attribute's memory.
bool is_sound(const draco::PointCloud& cloud, const draco::PointAttribute& attribute) {
  if (!attribute.buffer()) return false;
  const std::uint64_t end = static_cast<std::uint64_t>(attribute.byte_offset()) +
                            static_cast<std::uint64_t>(attribute.byte_stride()) * attribute.size();
  if (end > attribute.buffer()->data_size()) return false;
  if (attribute.is_mapping_identity()) return attribute.size() >= cloud.num_points();
  if (attribute.indices_map_size() < cloud.num_points()) return false;
  for (draco::PointIndex i(0); i < cloud.num_points(); ++i)
    if (attribute.mapped_index(i).value() >= attribute.size()) return false;
  return true;
}

double largest_of(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return std::numeric_limits<std::int8_t>::max();
    case draco::DT_UINT8:
      return std::numeric_limits<std::uint8_t>::max();
    case draco::DT_INT16:
      return std::numeric_limits<std::int16_t>::max();
    case draco::DT_UINT16:
      return std::numeric_limits<std::uint16_t>::max();
    default:
      return 1.0;
  }
}

Eigen::Vector3d value_of(const draco::PointAttribute& attribute, std::size_t point_idx) {
  std::array<double, 3> value{};
  const auto idx = attribute.mapped_index(draco::PointIndex(static_cast<std::uint32_t>(point_idx)));
  attribute.ConvertValue<double, 3>(idx, value.data());
  return {value[0], value[1], value[2]};
}

}  // namespace

void check_points_per_byte(std::uint64_t points, std::size_t bytes, std::size_t file_byte) {
  if (points / kMaxPointsPerByte > bytes)
    fail_at_byte("says it holds " + std::to_string(points) + " points in " + std::to_string(bytes) + " bytes",
                 file_byte, kHintDamaged);
}

DracoGeometry::DracoGeometry(std::span<const std::byte> stream, std::size_t file_byte,
                             const DracoAttributeIds& ids, const ScanLimits& limits)
    : decoded_(std::make_unique<Decoded>()) {
  const Counts counts = StreamHead(stream, file_byte).counts();
  check_points_per_byte(counts.points, stream.size(), file_byte);
  check_points_per_byte(counts.faces / 2, stream.size(), file_byte);
  CloudBuilder::check_count(counts.points, limits, "Draco header");
  Decoded& d = *decoded_;
  d.cloud = decode(stream, file_byte);
  CloudBuilder::check_count(d.cloud->num_points(), limits, "Draco points");
  d.mesh = dynamic_cast<const draco::Mesh*>(d.cloud.get());
  d.position = find_attribute(*d.cloud, ids.position, draco::GeometryAttribute::POSITION);
  d.normal = find_attribute(*d.cloud, ids.normal, draco::GeometryAttribute::NORMAL);
  d.colour = find_attribute(*d.cloud, ids.colour, draco::GeometryAttribute::COLOR);
  if (!d.position) fail_at_byte("the Draco stream has no positions", file_byte, "export with positions");
  for (const draco::PointAttribute* attribute : {d.position, d.normal, d.colour})
    if (attribute && !is_sound(*d.cloud, *attribute))
      fail_at_byte("a Draco attribute is shorter than its points", file_byte, kHintDamaged);
  for (std::size_t i = 0; i < triangle_count(); ++i)
    if ((triangle(i).array() < 0).any() || triangle(i).maxCoeff() >= static_cast<int>(point_count()))
      fail_at_byte(
          "a Draco triangle names a vertex beyond the " + std::to_string(point_count()) + " there are",
          file_byte, kHintDamaged);
}

DracoGeometry::~DracoGeometry() = default;

std::size_t DracoGeometry::point_count() const {
  return decoded_->cloud->num_points();
}
std::size_t DracoGeometry::triangle_count() const {
  return decoded_->mesh ? decoded_->mesh->num_faces() : 0;
}
bool DracoGeometry::has_normals() const {
  return decoded_->normal;
}
bool DracoGeometry::has_colours() const {
  return decoded_->colour;
}

Eigen::Vector3d DracoGeometry::position(std::size_t point_idx) const {
  return value_of(*decoded_->position, point_idx);
}
Eigen::Vector3d DracoGeometry::normal(std::size_t point_idx) const {
  return value_of(*decoded_->normal, point_idx);
}

Eigen::Vector3d DracoGeometry::colour(std::size_t point_idx) const {
  const draco::PointAttribute& attribute = *decoded_->colour;
  const bool is_scaled = attribute.normalized();  // ConvertValue has done it
  return value_of(attribute, point_idx) / (is_scaled ? 1.0 : largest_of(attribute.data_type()));
}

Eigen::Vector3i DracoGeometry::triangle(std::size_t triangle_idx) const {
  const draco::Mesh::Face& face =
      decoded_->mesh->face(draco::FaceIndex(static_cast<std::uint32_t>(triangle_idx)));
  return {static_cast<int>(face[0].value()), static_cast<int>(face[1].value()),
          static_cast<int>(face[2].value())};
}

}  // namespace phiz::readers
