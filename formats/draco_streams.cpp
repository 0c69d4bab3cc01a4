#include "formats/draco_streams.h"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "formats/error.h"

namespace phiz {
namespace {

using draco::GeometryAttribute;

constexpr int kTextureBits = 16;
constexpr int kTextureSteps = 65535;
constexpr int kMostPositionBits = 22;
constexpr int kSpeed = 7;  // 0 slow and small, 10 fast

/// Appends a column of `rows`, each of `Row`'s scalars, one per point.
template <typename Row>
int add_attribute(draco::PointCloud& cloud, GeometryAttribute::Type kind, int components,
                  draco::DataType type, std::span<const Row> rows) {
  GeometryAttribute attribute;
  const bool normalised = kind == GeometryAttribute::COLOR;
  attribute.Init(kind, nullptr, static_cast<std::uint8_t>(components), type, normalised, sizeof(Row), 0);
  const int id =
      cloud.AddAttribute(attribute, true, static_cast<draco::AttributeValueIndex::ValueType>(rows.size()));
  draco::PointAttribute& column = *cloud.attribute(id);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    column.SetAttributeValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(i)), &rows[i]);
  }
  return id;
}

void set_triangles(draco::Mesh& mesh, std::span<const Eigen::Vector3i> triangles, std::size_t vertex_count) {
  mesh.set_num_points(static_cast<std::uint32_t>(vertex_count));
  mesh.SetNumFaces(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    draco::Mesh::Face face;
    for (std::size_t k = 0; k < 3; ++k) {
      face[k] = draco::PointIndex(static_cast<std::uint32_t>(triangles[t][static_cast<int>(k)]));
    }
    mesh.SetFace(draco::FaceIndex(static_cast<std::uint32_t>(t)), face);
  }
}

std::string finish(draco::ExpertEncoder& encoder, int speed = kSpeed) {
  draco::EncoderBuffer buffer;
  encoder.SetSpeedOptions(speed, speed);
  const draco::Status status = encoder.EncodeToBuffer(&buffer);
  if (!status.ok()) throw FormatError(std::string("Draco cannot write: ") + status.error_msg());
  return {buffer.data(), buffer.size()};
}

std::string finish_mesh(draco::ExpertEncoder& encoder) {
  encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
  encoder.options().SetGlobalBool("compress_connectivity", true);
  return finish(encoder);
}

/// The head of a stream without metadata: magic, version, kind, method, flags; then the counts, behind a byte
/// that says how edgebreaker coded its symbols.
class StreamHead {
 public:
  StreamHead(std::string_view bytes, std::uint8_t kind, bool may_be_edgebreaker = false) : bytes_(bytes) {
    const bool ours = bytes.size() >= 12 &&
                      bytes.starts_with(kind == draco::POINT_CLOUD ? "DRACO\2\3" : "DRACO\2\2") &&
                      byte_at(7) == kind && byte_at(8) <= (may_be_edgebreaker ? 1 : 0) && byte_at(9) == 0 &&
                      byte_at(10) == 0;
    if (!ours)
      throw FormatError("is no Draco stream of version 2.2 (mesh) or 2.3 (points) as phiz writes it");
    is_edgebreaker_ = byte_at(8) == 1;
    if (is_edgebreaker_) at_ = 12;
  }
  bool is_edgebreaker() const { return is_edgebreaker_; }
  std::uint64_t take_varint() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 35 && at_ < bytes_.size(); shift += 7) {
      const std::uint8_t byte = byte_at(at_++);
      value |= std::uint64_t{byte & 0x7fu} << shift;
      if (byte < 0x80) break;
    }
    return value;
  }
  std::uint32_t take_word() {
    std::uint32_t word = 0;
    if (bytes_.size() - at_ >= 4) std::memcpy(&word, bytes_.data() + at_, 4);
    return word;
  }

 private:
  std::uint8_t byte_at(std::size_t at) const { return static_cast<std::uint8_t>(bytes_[at]); }
  std::string_view bytes_;
  std::size_t at_ = 11;
  bool is_edgebreaker_ = false;
};

/// A column by its id, of just this shape, with a value for every point.
const draco::PointAttribute& checked_attribute(const draco::PointCloud& cloud, std::uint32_t id,
                                               int components, draco::DataType type) {
  const draco::PointAttribute* attribute = cloud.GetAttributeByUniqueId(id);
  if (attribute == nullptr || attribute->num_components() != components || attribute->data_type() != type ||
      attribute->size() != cloud.num_points() || !attribute->is_mapping_identity()) {
    throw FormatError("Draco stream has other attributes");
  }
  return *attribute;
}

template <typename Row>
Row row_at(const draco::PointAttribute& column, std::size_t row) {
  Row values;
  column.GetValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(row)), values.data());
  return values;
}

/// The lattice step nearest to a float; `limit` bounds what may be asked.
int nearest_step(double value, double limit) {
  if (!(std::abs(value) <= limit)) throw FormatError("Draco stream has values out of range");
  return static_cast<int>(std::floor(value + 0.5));
}

/// The box of a lattice's points and the bits its coordinates take.
struct Lattice {
  Eigen::Vector3i low, high;
  int bits = 1;
};

Lattice lattice_of(const std::vector<Eigen::Vector3i>& positions) {
  Lattice lattice{positions.front(), positions.front()};
  for (const Eigen::Vector3i& q : positions) {
    lattice.low = lattice.low.cwiseMin(q);
    lattice.high = lattice.high.cwiseMax(q);
  }
  const auto extent = static_cast<unsigned>((lattice.high - lattice.low).maxCoeff());
  lattice.bits = std::max(1, static_cast<int>(std::bit_width(extent)));
  if (lattice.bits > kMostPositionBits)
    throw FormatError("position step is too fine for the size of the head");
  return lattice;
}

void quantise_to(const Lattice& lattice, double step, int attribute_id, draco::ExpertEncoder& encoder) {
  const Eigen::Vector3f origin = (lattice.low.cast<double>() * step).cast<float>();
  const auto range = static_cast<float>(static_cast<double>((1u << lattice.bits) - 1) * step);
  encoder.SetAttributeExplicitQuantization(attribute_id, lattice.bits, 3, origin.data(), range);
}

/// Edgebreaker at its smallest.
std::string finish_small(draco::ExpertEncoder& encoder) {
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  return finish(encoder, 0);
}

void append_triangles(const draco::Mesh& stream, std::size_t vertex_count, LatticeMesh& mesh) {
  for (std::uint32_t t = 0; t < stream.num_faces(); ++t) {
    const draco::Mesh::Face& face = stream.face(draco::FaceIndex(t));
    for (draco::PointIndex corner : face) {
      if (corner.value() >= vertex_count) throw FormatError("Draco stream has corners out of range");
    }
    mesh.triangles.emplace_back(face[0].value(), face[1].value(), face[2].value());
  }
}

}  // namespace

std::string encode_lattice_mesh(const LatticeMesh& mesh, double step) {
  const Lattice lattice = lattice_of(mesh.positions);
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector2f> texture;
  for (const Eigen::Vector3i& q : mesh.positions)
    positions.push_back((q.cast<double>() * step).cast<float>());
  for (const Eigen::Vector2i& t : mesh.texture)
    texture.push_back((t.cast<double>() / kTextureSteps).cast<float>());
  draco::Mesh stream;
  set_triangles(stream, mesh.triangles, mesh.positions.size());
  const std::span<const Eigen::Vector3f> position_rows(positions);
  const std::span<const Eigen::Vector2f> texture_rows(texture);
  const int position_id =
      add_attribute(stream, GeometryAttribute::POSITION, 3, draco::DT_FLOAT32, position_rows);
  const int texture_id =
      add_attribute(stream, GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32, texture_rows);
  const Eigen::Vector2f zero = Eigen::Vector2f::Zero();
  draco::ExpertEncoder encoder(stream);
  quantise_to(lattice, step, position_id, encoder);
  encoder.SetAttributeExplicitQuantization(texture_id, kTextureBits, 2, zero.data(), 1.0f);
  std::string bytes = finish_mesh(encoder);
  const LatticeMesh copy = decode_lattice_mesh(bytes, step, mesh.positions.size(), mesh.triangles.size());
  if (copy.positions != mesh.positions || copy.triangles != mesh.triangles || copy.texture != mesh.texture) {
    throw FormatError("position step is too fine for the place of the head");
  }
  return bytes;
}

LatticeMesh decode_lattice_mesh(std::string_view bytes, double step, std::size_t vertex_count,
                                std::size_t triangle_count) {
  StreamHead head(bytes, draco::TRIANGULAR_MESH);
  if (head.take_varint() != triangle_count || head.take_varint() != vertex_count) {
    throw FormatError("Draco stream has other counts");
  }
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) throw FormatError(std::string("Draco cannot read: ") + decoded.status().error_msg());
  const draco::Mesh& stream = *decoded.value();
  if (stream.num_points() != vertex_count || stream.num_faces() != triangle_count) {
    throw FormatError("Draco stream has other counts");
  }
  const auto& positions = checked_attribute(stream, 0, 3, draco::DT_FLOAT32);
  const auto& texture = checked_attribute(stream, 1, 2, draco::DT_FLOAT32);
  LatticeMesh mesh;
  for (std::size_t i = 0; i < vertex_count; ++i) {
    const Eigen::Vector3d p = row_at<Eigen::Vector3f>(positions, i).cast<double>() / step;
    const Eigen::Vector2d t = row_at<Eigen::Vector2f>(texture, i).cast<double>() * kTextureSteps;
    mesh.positions.emplace_back(nearest_step(p.x(), 1e9), nearest_step(p.y(), 1e9), nearest_step(p.z(), 1e9));
    mesh.texture.emplace_back(nearest_step(t.x(), kTextureSteps), nearest_step(t.y(), kTextureSteps));
    if (mesh.texture.back().minCoeff() < 0) throw FormatError("Draco stream has values out of range");
  }
  append_triangles(stream, vertex_count, mesh);
  return mesh;
}

std::string encode_lattice_surface(const std::vector<Eigen::Vector3i>& positions,
                                   const std::vector<Eigen::Vector3i>& triangles, double step) {
  const Lattice lattice = lattice_of(positions);
  std::vector<Eigen::Vector3f> rows;
  for (const Eigen::Vector3i& q : positions) rows.push_back((q.cast<double>() * step).cast<float>());
  // Edgebreaker gives back what is handed over last first, each triangle with its last corner first.
  std::vector<Eigen::Vector3i> backwards;
  for (auto t = triangles.rbegin(); t != triangles.rend(); ++t)
    backwards.emplace_back((*t)[2], (*t)[0], (*t)[1]);
  for (const bool is_edgebreaker : {true, false}) {
    draco::Mesh stream;
    set_triangles(stream, is_edgebreaker ? backwards : triangles, positions.size());
    const int id = add_attribute(stream, GeometryAttribute::POSITION, 3, draco::DT_FLOAT32,
                                 std::span<const Eigen::Vector3f>(rows));
    draco::ExpertEncoder encoder(stream);
    quantise_to(lattice, step, id, encoder);
    try {
      std::string bytes = is_edgebreaker ? finish_small(encoder) : finish_mesh(encoder);
      const LatticeMesh copy = decode_lattice_surface(bytes, step, positions.size(), triangles.size());
      if (copy.positions == positions && copy.triangles == triangles) return bytes;
    } catch (const FormatError&) {  // other counts: vertices without a triangle, or used by two fans
    }
  }
  throw FormatError("position step is too fine for the place of the head");
}

LatticeMesh decode_lattice_surface(std::string_view bytes, double step, std::size_t vertex_count,
                                   std::size_t triangle_count) {
  StreamHead head(bytes, draco::TRIANGULAR_MESH, true);
  const std::uint64_t first = head.take_varint(), second = head.take_varint();
  const bool right = head.is_edgebreaker() ? first == vertex_count && second == triangle_count
                                           : first == triangle_count && second == vertex_count;
  if (!right) throw FormatError("Draco stream has other counts");
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) throw FormatError(std::string("Draco cannot read: ") + decoded.status().error_msg());
  const draco::Mesh& stream = *decoded.value();
  if (stream.num_points() != vertex_count || stream.num_faces() != triangle_count)
    throw FormatError("Draco stream has other counts");
  const draco::PointAttribute* positions = stream.GetAttributeByUniqueId(0);
  if (positions == nullptr || positions->num_components() != 3 || positions->data_type() != draco::DT_FLOAT32)
    throw FormatError("Draco stream has other attributes");
  LatticeMesh mesh;
  for (std::uint32_t i = 0; i < vertex_count; ++i) {
    const draco::AttributeValueIndex row = positions->mapped_index(draco::PointIndex(i));
    if (row.value() >= positions->size()) throw FormatError("Draco stream has other attributes");
    Eigen::Vector3f p;
    positions->GetValue(row, p.data());
    const Eigen::Vector3d q = p.cast<double>() / step;
    mesh.positions.emplace_back(nearest_step(q.x(), 1e9), nearest_step(q.y(), 1e9), nearest_step(q.z(), 1e9));
  }
  append_triangles(stream, vertex_count, mesh);
  return mesh;
}

SurfaceStream encode_surface(const TriangleMesh& mesh, double step) {
  std::vector<Eigen::Vector3i> positions;
  for (const Eigen::Vector3f& p : mesh.positions) {
    const Eigen::Vector3d q = p.cast<double>() / step;
    positions.emplace_back(nearest_step(q.x(), 1e8), nearest_step(q.y(), 1e8), nearest_step(q.z(), 1e8));
  }
  const Lattice lattice = lattice_of(positions);
  std::vector<Eigen::Vector3f> rows;
  for (const Eigen::Vector3i& q : positions) rows.push_back((q.cast<double>() * step).cast<float>());
  draco::Mesh stream;
  set_triangles(stream, mesh.triangles, rows.size());
  const int id = add_attribute(stream, GeometryAttribute::POSITION, 3, draco::DT_FLOAT32,
                               std::span<const Eigen::Vector3f>(rows));
  draco::ExpertEncoder encoder(stream);
  quantise_to(lattice, step, id, encoder);
  SurfaceStream result;
  result.bytes = finish_small(encoder);
  draco::DecoderBuffer buffer;
  buffer.Init(result.bytes.data(), result.bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) throw FormatError(std::string("Draco cannot read: ") + decoded.status().error_msg());
  result.vertex_count = decoded.value()->num_points();
  result.triangle_count = decoded.value()->num_faces();
  result.low = (lattice.low.cast<double>() * step).cast<float>();
  result.high = (lattice.high.cast<double>() * step).cast<float>();
  return result;
}

std::string encode_integers(std::span<const std::int32_t> numbers) {
  draco::PointCloud cloud;
  cloud.set_num_points(static_cast<std::uint32_t>(numbers.size()));
  const int id = add_attribute(cloud, GeometryAttribute::GENERIC, 1, draco::DT_INT32, numbers);
  draco::ExpertEncoder encoder(cloud);
  encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
  encoder.SetAttributePredictionScheme(id, draco::PREDICTION_NONE);
  return finish(encoder);
}

std::vector<std::int32_t> decode_integers(std::string_view bytes, std::size_t count) {
  if (StreamHead(bytes, draco::POINT_CLOUD).take_word() != count)
    throw FormatError("Draco stream has other counts");
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodePointCloudFromBuffer(&buffer);
  if (!decoded.ok()) throw FormatError(std::string("Draco cannot read: ") + decoded.status().error_msg());
  if (decoded.value()->num_points() != count) throw FormatError("Draco stream has other counts");
  const auto& column = checked_attribute(*decoded.value(), 0, 1, draco::DT_INT32);
  std::vector<std::int32_t> numbers(count);
  for (std::size_t i = 0; i < count; ++i) {
    column.GetValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(i)), &numbers[i]);
  }
  return numbers;
}

std::string encode_draco(const TriangleMesh& mesh) {
  check_mesh(mesh);
  if (mesh.positions.empty() || mesh.triangles.empty())
    throw FormatError("Draco needs vertices and triangles");
  draco::Mesh stream;
  set_triangles(stream, mesh.triangles, mesh.vertex_count());
  const int position_id = add_attribute(stream, GeometryAttribute::POSITION, 3, draco::DT_FLOAT32,
                                        std::span<const Eigen::Vector3f>(mesh.positions));
  draco::ExpertEncoder encoder(stream);
  encoder.SetAttributeQuantization(position_id, 16);
  if (!mesh.normals.empty()) {
    encoder.SetAttributeQuantization(add_attribute(stream, GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32,
                                                   std::span<const Eigen::Vector3f>(mesh.normals)),
                                     10);
  }
  if (!mesh.uv.empty()) {
    encoder.SetAttributeQuantization(add_attribute(stream, GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32,
                                                   std::span<const Eigen::Vector2f>(mesh.uv)),
                                     14);
  }
  if (!mesh.colours.empty()) {
    add_attribute(stream, GeometryAttribute::COLOR, 3, draco::DT_UINT8,
                  std::span<const std::array<std::uint8_t, 3>>(mesh.colours));
  }
  return finish_mesh(encoder);
}

}  // namespace phiz
