#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include "tests/formats/scan_samples.h"

namespace phiz::test {
namespace {

/// Attribute ids: 0 position, 1 normal, 2 colour.
template <typename Number>
void add_attribute(draco::PointCloud& cloud, draco::GeometryAttribute::Type kind, draco::DataType type,
                   const Number* first, std::size_t rows) {
  draco::GeometryAttribute attribute;
  attribute.Init(kind, nullptr, 3, type, type == draco::DT_UINT8, 3 * sizeof(Number), 0);
  const int id = cloud.AddAttribute(attribute, true, static_cast<std::uint32_t>(rows));
  for (std::size_t i = 0; i < rows; ++i)
    cloud.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(i)),
                                           first + 3 * i);
}

void fill(draco::PointCloud& cloud, const ScanSample& sample) {
  const std::size_t rows = sample.positions.size();
  cloud.set_num_points(static_cast<std::uint32_t>(rows));
  add_attribute(cloud, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, sample.positions[0].data(),
                rows);
  add_attribute(cloud, draco::GeometryAttribute::NORMAL, draco::DT_FLOAT32, sample.normals[0].data(), rows);
  add_attribute(cloud, draco::GeometryAttribute::COLOR, draco::DT_UINT8, sample.colours[0].data(), rows);
}

std::string encode(draco::ExpertEncoder& encoder, int method) {
  encoder.SetSpeedOptions(5, 5);
  encoder.SetEncodingMethod(method);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) return {};
  return {buffer.data(), buffer.size()};
}

}  // namespace

std::string write_drc(const ScanSample& sample, bool as_mesh) {
  if (!as_mesh) {
    draco::PointCloud cloud;
    fill(cloud, sample);
    draco::ExpertEncoder encoder(cloud);
    return encode(encoder, draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
  }
  draco::Mesh mesh;
  fill(mesh, sample);
  for (const Eigen::Vector3i& t : sample.triangles)
    mesh.AddFace({draco::PointIndex(static_cast<std::uint32_t>(t[0])),
                  draco::PointIndex(static_cast<std::uint32_t>(t[1])),
                  draco::PointIndex(static_cast<std::uint32_t>(t[2]))});
  draco::ExpertEncoder encoder(mesh);
  return encode(encoder, draco::MESH_SEQUENTIAL_ENCODING);
}

std::string write_draco_glb(const ScanSample& sample) {
  const std::string stream = write_drc(sample, true);
  const std::string count = std::to_string(sample.positions.size());
  const std::string json =
      R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_draco_mesh_compression"],"nodes":[{"mesh":0}],)"
      R"("buffers":[{"byteLength":)" +
      std::to_string(stream.size()) + R"(}],"bufferViews":[{"buffer":0,"byteLength":)" +
      std::to_string(stream.size()) + R"(}],"accessors":[{"count":)" + count +
      R"(,"componentType":5126,"type":"VEC3"}],"meshes":[{"primitives":[{)" +
      R"("attributes":{"POSITION":0},"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{)" +
      R"("POSITION":0,"NORMAL":1,"COLOR_0":2}}}}]}]})";
  return glb_of(json, stream);
}

}  // namespace phiz::test
