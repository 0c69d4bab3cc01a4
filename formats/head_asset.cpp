#include "formats/head_asset.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

#include "formats/content_seal.h"
#include "formats/draco_streams.h"
#include "formats/error.h"
#include "formats/glb_chunks.h"
#include "formats/head_asset_document.h"
#include "formats/head_asset_parts.h"
#include "formats/residual_coder.h"
#include "formats/text.h"

namespace phiz {
namespace {

using head_asset_document::Document;
using head_asset_document::Level;
using head_asset_document::Stream;
namespace parts = head_asset_parts;

std::string_view bytes_of(std::string_view bin, const Stream& stream) {
  return bin.substr(stream.offset, stream.length);
}

std::string_view checked_bytes_of(std::string_view bin, const Stream& stream, const char* what) {
  const std::string_view bytes = bytes_of(bin, stream);
  if (parts::sum_of(bytes) != stream.sum)
    throw FormatError(std::string(what) + " is damaged: its sum is another (byte " +
                      std::to_string(stream.offset) + " of the second chunk)");
  return bytes;
}

void check_document(const Document& document) {
  head_asset_document::check_name(document.template_digest, "template digest");
  for (const auto& [name, digest] : document.provenance) {
    head_asset_document::check_name(name, "provenance");
    head_asset_document::check_name(digest, "provenance");
  }
  parts::check_steps(1, document.position_step_mm);
  for (const Level& level : document.levels) parts::check_steps(level.step_mm, 1);
  if (document.texture_steps < 255 || document.texture_steps > 65535 || document.confidence_step < 1 ||
      document.confidence_step > 255)
    throw FormatError("quantisation step is out of range");
  if (!document.scan_from_head.allFinite()) throw FormatError("scan_from_head is not finite");
  if (!(document.tolerance_mm >= 0) || !std::isfinite(document.tolerance_mm))
    throw FormatError("tolerance is no distance");
  if (document.vertex_count > parts::kMostVertices || document.triangle_count > 2 * parts::kMostVertices ||
      document.triangle_count == 0) {
    throw FormatError("head claims " + std::to_string(document.vertex_count) + " vertices and " +
                      std::to_string(document.triangle_count) + " triangles");
  }
}

void append_positions(const std::vector<Eigen::Vector3i>& lattice, double step, HeadAsset& head) {
  for (const Eigen::Vector3i& q : lattice) {
    if (q.cwiseAbs().maxCoeff() > parts::kLargestSteps) throw FormatError("position is too large");
    const auto coordinate = [&](int k) { return parts::from_steps(q[k], step); };
    head.positions.emplace_back(coordinate(0), coordinate(1), coordinate(2));
  }
}

/// The control mesh and its (u,v). Schema 1 has both in one stream, v downwards.
LevelTopology read_control(std::string_view bin, const Document& document, HeadAsset& head) {
  const double step = document.position_step_mm, share = 1.0 / document.texture_steps;
  if (document.schema == 1) {
    const LatticeMesh mesh = decode_lattice_mesh(bytes_of(bin, document.mesh), step, document.vertex_count,
                                                 document.triangle_count);
    head.triangles = mesh.triangles;
    append_positions(mesh.positions, step, head);
    for (const Eigen::Vector2i& t : mesh.texture)
      head.uv.emplace_back(parts::from_steps(t.x(), share),
                           parts::from_steps(document.texture_steps - t.y(), share));
    return {head.triangles, head.positions.size()};
  }
  LatticeMesh mesh = decode_lattice_surface(checked_bytes_of(bin, document.mesh, "control mesh"), step,
                                            document.vertex_count, document.triangle_count);
  head.triangles = std::move(mesh.triangles);
  append_positions(mesh.positions, step, head);
  LevelTopology control(head.triangles, head.positions.size());
  if (document.texture.end() > bin.size()) return control;  // a prefix
  for (const Eigen::Vector2i& t : parts::decode_texture(
           control, head.triangles, checked_bytes_of(bin, document.texture, "texture coordinates"),
           document.texture_steps))
    head.uv.emplace_back(parts::from_steps(t.x(), share), parts::from_steps(t.y(), share));
  return control;
}

void append_level(const std::vector<std::int32_t>& numbers, std::size_t first, double step, HeadAsset& head) {
  std::vector<float>& displacements = head.displacements_mm.emplace_back(first, 0.0f);
  displacements.reserve(first + numbers.size());
  for (const std::int32_t steps : numbers) {
    if (std::abs(static_cast<double>(steps)) > 2 * parts::kLargestSteps)
      throw FormatError("displacement is too large");
    displacements.push_back(parts::from_steps(steps, step));
  }
}

void append_confidences(std::string_view stream, std::size_t count, int step, HeadAsset& head) {
  std::vector<std::uint8_t> confidences;
  if (!head.confidences.empty()) confidences = head.confidences.back();
  for (const std::int32_t value : decode_integers(stream, count)) {
    if (value < 0 || value > 255 / step + 1) throw FormatError("confidence is no byte");
    confidences.push_back(static_cast<std::uint8_t>(std::min(value * step, 255)));
  }
  head.confidences.push_back(std::move(confidences));
}

/// Counts are those that the control mesh leads to, and none is believed before the streams are long enough.
void check_levels(const LevelTopology& control, const Document& document) {
  std::size_t vertices = control.vertex_count(), edges = control.next_vertex_count() - vertices,
              faces = control.triangle_count(), before = 0;
  for (std::size_t level = 0; level < document.levels.size(); ++level) {
    const Level& entry = document.levels[level];
    if (vertices > parts::kMostVertices) throw FormatError("level " + std::to_string(level) + " is too fine");
    if (entry.vertex_count != vertices)
      throw FormatError("level " + std::to_string(level) + " has not " + std::to_string(vertices) +
                        " vertices");
    if (document.schema > 1 && vertices - before > ResidualModel::most_numbers(entry.displacements.length))
      throw FormatError("level " + std::to_string(level) + " is too short for its vertices");
    before = vertices;
    vertices += edges;
    edges = 2 * edges + 3 * faces;
    faces *= 4;
  }
}

/// Levels 0 .. count-1.
void read_levels(std::string_view bin, const Document& document, std::size_t count, LevelTopology topology,
                 HeadAsset& head) {
  check_levels(topology, document);
  ResidualModel model;
  for (std::size_t level = 0; level < count; ++level) {
    const Level& entry = document.levels[level];
    const std::size_t first = level == 0 ? 0 : document.levels[level - 1].vertex_count;
    if (document.schema == 1) {
      append_level(decode_integers(bytes_of(bin, entry.displacements), entry.vertex_count - first), first,
                   entry.step_mm, head);
    } else {
      if (level > 0) topology = topology.next();
      append_level(model.decode(topology, checked_bytes_of(bin, entry.displacements, "a level")), first,
                   entry.step_mm, head);
    }
    if (document.has_confidences && entry.confidences.end() <= bin.size())
      append_confidences(bytes_of(bin, entry.confidences), entry.vertex_count - first,
                         document.confidence_step, head);
  }
}

HeadAsset read_document(std::string_view bin, const Document& document, std::size_t level_count) {
  check_document(document);
  HeadAsset head;
  head.template_digest = document.template_digest;
  head.scan_from_head = document.scan_from_head;
  head.tolerance_mm = document.tolerance_mm;
  head.provenance = document.provenance;
  LevelTopology control = read_control(bin, document, head);
  read_levels(bin, document, level_count, std::move(control), head);
  return head;
}

constexpr std::size_t kBeforeJson = 20, kBeforeBin = 8;

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, 4);
  return word;
}

/// The JSON of a file that may have been cut behind it, and where the second chunk's content begins.
std::string_view json_of_prefix(std::string_view bytes) {
  if (bytes.size() < kBeforeJson || bytes.substr(0, 4) != "glTF" || bytes.substr(16, 4) != "JSON")
    throw FormatError("is not a glb (byte 0)");
  const std::size_t length = word_at(bytes, 12);
  if (length > bytes.size() - kBeforeJson || bytes.size() - kBeforeJson - length < kBeforeBin)
    throw FormatError("ends within its document (byte " + std::to_string(bytes.size()) + ")");
  return bytes.substr(kBeforeJson, length);
}

}  // namespace

HeadAsset read_head_asset(std::istream& in) {
  const std::string bytes = read_all(in);
  const GlbChunks chunks = split_glb(bytes);
  const std::size_t seal = head_asset_document::find_seal(bytes);
  if (bytes.substr(seal, head_asset_document::kSealLength) !=
      digest_without(bytes, seal, head_asset_document::kSealLength)) {
    throw FormatError("is damaged: its content does not match its seal (byte " + std::to_string(seal) + ")");
  }
  try {
    const Document document = head_asset_document::parse(chunks.json, chunks.bin.size());
    return read_document(chunks.bin, document, document.levels.size());
  } catch (const std::bad_alloc&) {
    throw FormatError("claims more than memory holds");
  }
}

HeadAsset read_head_asset_prefix(std::string_view bytes) {
  const std::string_view json = json_of_prefix(bytes);
  const std::size_t begin = kBeforeJson + json.size() + kBeforeBin;
  const std::string_view bin = bytes.substr(begin);
  try {
    const Document document = head_asset_document::parse(
        json, std::max<std::size_t>(bin.size(), word_at(bytes, begin - kBeforeBin)));
    if (document.schema == 1) throw FormatError("a file of schema 1 can only be read whole");
    if (document.mesh.end() > bin.size())
      throw FormatError("ends within its control mesh (byte " + std::to_string(bytes.size()) + ")");
    std::size_t count = 0;
    while (count < document.levels.size() && document.levels[count].displacements.end() <= bin.size())
      ++count;
    return read_document(bin, document, count);
  } catch (const std::bad_alloc&) {
    throw FormatError("claims more than memory holds");
  }
}

std::vector<HeadAssetPart> list_head_asset_parts(std::string_view bytes) {
  const GlbChunks chunks = split_glb(bytes);
  const Document document = head_asset_document::parse(chunks.json, chunks.bin.size());
  const std::size_t begin = kBeforeJson + chunks.json.size() + kBeforeBin;
  std::vector<HeadAssetPart> list = {{"document", begin, begin}};
  const auto add = [&](const std::string& name, const Stream& stream) {
    if (stream.length > 0) list.push_back({name, begin + stream.end(), stream.length});
  };
  add("control mesh", document.mesh);
  for (std::size_t k = 0; k < document.levels.size(); ++k)
    add("level " + std::to_string(k), document.levels[k].displacements);
  add("texture coordinates", document.texture);
  for (std::size_t k = 0; k < document.levels.size(); ++k)
    add("confidence " + std::to_string(k), document.levels[k].confidences);
  add("shown mesh", document.shown);
  return list;
}

}  // namespace phiz
