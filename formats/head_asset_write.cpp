#include <algorithm>
#include <cmath>

#include "formats/content_seal.h"
#include "formats/draco_streams.h"
#include "formats/error.h"
#include "formats/glb_chunks.h"
#include "formats/head_asset.h"
#include "formats/head_asset_document.h"
#include "formats/head_asset_parts.h"
#include "formats/residual_coder.h"
#include "formats/text.h"

namespace phiz {
namespace {

using head_asset_document::Document;
using head_asset_document::Stream;
namespace parts = head_asset_parts;

void check_head(const HeadAsset& head, const HeadAssetOptions& options) {
  head_asset_document::check_name(head.template_digest, "template digest");
  for (const auto& [name, digest] : head.provenance) {
    head_asset_document::check_name(name, "provenance");
    head_asset_document::check_name(digest, "provenance");
  }
  parts::check_steps(options.displacement_step_mm, options.position_step_mm);
  if (options.texture_steps < 255 || options.texture_steps > 65535 || options.confidence_step < 1 ||
      options.confidence_step > 255)
    throw FormatError("quantisation step is out of range");
  if (!head.scan_from_head.allFinite()) throw FormatError("scan_from_head is not finite");
  if (!std::isfinite(head.tolerance_mm) || head.tolerance_mm < 0)
    throw FormatError("tolerance is no distance");
  if (head.triangles.empty()) throw FormatError("head has no triangles");
  if (head.uv.size() != head.positions.size()) throw FormatError("head has not one (u,v) per vertex");
  if (!head.confidences.empty() && head.confidences.size() != head.displacements_mm.size()) {
    throw FormatError(std::to_string(head.confidences.size()) + " levels of confidences for " +
                      std::to_string(head.displacements_mm.size()) + " of displacements");
  }
}

void check_level(const HeadAsset& head, std::size_t level, std::size_t vertex_count) {
  if (vertex_count > parts::kMostVertices)
    throw FormatError("level " + std::to_string(level) + " is too fine");
  const bool right = head.displacements_mm[level].size() == vertex_count &&
                     (head.confidences.empty() || head.confidences[level].size() == vertex_count);
  if (!right) {
    throw FormatError("level " + std::to_string(level) + " has not " + std::to_string(vertex_count) +
                      " values");
  }
}

std::vector<std::int32_t> new_displacements(const HeadAsset& head, std::size_t level, std::size_t first,
                                            double step) {
  const std::vector<float>& values = head.displacements_mm[level];
  std::vector<std::int32_t> steps;
  steps.reserve(values.size() - first);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i < first && values[i] != 0.0f) {
      throw FormatError("level " + std::to_string(level) + " displaces a vertex of the level before (" +
                        std::to_string(i) + ")");
    }
    if (i >= first) steps.push_back(parts::to_steps(values[i], step, "displacement", i));
  }
  return steps;
}

std::vector<std::int32_t> new_confidences(const HeadAsset& head, std::size_t level, std::size_t first,
                                          int step) {
  const std::vector<std::uint8_t>& values = head.confidences[level];
  if (first > 0 && !std::equal(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(first),
                               head.confidences[level - 1].begin())) {
    throw FormatError("level " + std::to_string(level) +
                      " does not repeat the confidences of the level before");
  }
  std::vector<std::int32_t> steps;
  for (std::size_t i = first; i < values.size(); ++i) steps.push_back((values[i] + step / 2) / step);
  return steps;
}

/// Appends streams to the BIN chunk and keeps where they lie.
class Streams {
 public:
  Stream add(const std::string& stream) {
    const Stream added{bin_.size(), stream.size(), parts::sum_of(stream)};
    bin_ += stream;
    return added;
  }
  std::string take() && { return std::move(bin_); }

 private:
  std::string bin_;
};

/// Returns the stream of texture coordinates, which goes behind the levels: no picture waits for it.
std::string write_control(const HeadAsset& head, const LevelTopology& control,
                          const HeadAssetOptions& options, Document& document, Streams& streams) {
  std::vector<Eigen::Vector3i> positions;
  std::vector<Eigen::Vector2i> texture;
  for (std::size_t i = 0; i < head.positions.size(); ++i) {
    const auto coordinate = [&](int k) {
      return parts::to_steps(head.positions[i][k], options.position_step_mm, "position", i);
    };
    positions.emplace_back(coordinate(0), coordinate(1), coordinate(2));
    const Eigen::Vector2f& uv = head.uv[i];
    if (!(uv.minCoeff() >= 0.0f && uv.maxCoeff() <= 1.0f)) {
      throw FormatError("(u,v) is not in [0,1] (" + std::to_string(i) + ")");
    }
    const auto share = [&](float value) {
      return static_cast<int>(double{value} * options.texture_steps + 0.5);
    };
    texture.emplace_back(share(uv.x()), share(uv.y()));
  }
  document.vertex_count = positions.size();
  document.triangle_count = head.triangles.size();
  document.mesh = streams.add(encode_lattice_surface(positions, head.triangles, options.position_step_mm));
  std::string stream = parts::encode_texture(control, head.triangles, texture);
  if (parts::decode_texture(control, head.triangles, stream, options.texture_steps) != texture)
    throw FormatError("texture coordinates do not survive their coding");
  document.shown_vertex_count = positions.size();
  document.shown_triangle_count = head.triangles.size();
  Eigen::Vector3i low = positions.front(), high = low;
  for (const Eigen::Vector3i& q : positions) {
    low = low.cwiseMin(q);
    high = high.cwiseMax(q);
  }
  document.low = (low.cast<double>() * options.position_step_mm).cast<float>();
  document.high = (high.cast<double>() * options.position_step_mm).cast<float>();
  return stream;
}

void write_levels(const HeadAsset& head, LevelTopology topology, const HeadAssetOptions& options,
                  const std::string& texture, Document& document, Streams& streams) {
  ResidualModel model, copy;
  std::vector<std::string> confidences;
  for (std::size_t level = 0; level < head.displacements_mm.size(); ++level) {
    if (level > 0) topology = topology.next();
    const std::size_t first = topology.first_new();
    const std::vector<std::int32_t> numbers =
        new_displacements(head, level, first, options.displacement_step_mm);
    const std::string stream = model.encode(topology, numbers);
    if (copy.decode(topology, stream) != numbers)
      throw FormatError("level " + std::to_string(level) + " does not survive its coding");
    document.levels.push_back(
        {topology.vertex_count(), options.displacement_step_mm, streams.add(stream), {}});
    if (document.has_confidences)
      confidences.push_back(encode_integers(new_confidences(head, level, first, options.confidence_step)));
  }
  document.texture = streams.add(texture);
  for (std::size_t level = 0; level < confidences.size(); ++level)
    document.levels[level].confidences = streams.add(confidences[level]);
}

void write_shown(const TriangleMesh& shown, const HeadAssetOptions& options, Document& document,
                 Streams& streams) {
  check_mesh(shown);
  if (shown.triangles.empty() || options.shown_level < 1 || options.shown_level > 8)
    throw FormatError("what is shown is no finer level");
  parts::check_steps(1, options.shown_step_mm);
  const SurfaceStream stream = encode_surface(shown, options.shown_step_mm);
  document.shown = streams.add(stream.bytes);
  document.shown_level = options.shown_level;
  document.shown_vertex_count = stream.vertex_count;
  document.shown_triangle_count = stream.triangle_count;
  document.low = stream.low;
  document.high = stream.high;
}

}  // namespace

void write_head_asset(const HeadAsset& head, const HeadAssetOptions& options, std::ostream& out) {
  check_head(head, options);
  const LevelTopology control(head.triangles, head.positions.size());
  std::size_t vertex_count = head.positions.size(), edges = control.next_vertex_count() - vertex_count,
              faces = head.triangles.size();
  for (std::size_t level = 0; level < head.displacements_mm.size(); ++level) {  // before any is made
    check_level(head, level, vertex_count);
    vertex_count += edges;
    edges = 2 * edges + 3 * faces;
    faces *= 4;
  }
  Document document;
  document.template_digest = head.template_digest;
  document.position_step_mm = options.position_step_mm;
  document.texture_steps = options.texture_steps;
  document.confidence_step = options.confidence_step;
  document.tolerance_mm = head.tolerance_mm;
  document.provenance = head.provenance;
  document.scan_from_head = head.scan_from_head;
  document.has_confidences = !head.confidences.empty();
  Streams streams;
  const std::string texture = write_control(head, control, options, document, streams);
  write_levels(head, control, options, texture, document, streams);
  if (options.shown != nullptr) write_shown(*options.shown, options, document, streams);
  const std::string bin = std::move(streams).take();
  document.bin_length = bin.size();
  std::string bytes = join_glb(head_asset_document::format(document), bin);
  const std::size_t seal = head_asset_document::find_seal(bytes);
  bytes.replace(seal, head_asset_document::kSealLength,
                digest_without(bytes, seal, head_asset_document::kSealLength));
  write_all(out, bytes);
}

}  // namespace phiz
