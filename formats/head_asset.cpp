#include "formats/head_asset.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/content_seal.h"
#include "formats/draco_streams.h"
#include "formats/error.h"
#include "formats/glb_chunks.h"
#include "formats/head_asset_document.h"
#include "formats/text.h"

namespace phiz {
namespace {

using head_asset_document::Document;
using head_asset_document::Stream;

constexpr std::size_t kMostVertices = std::size_t{1} << 25;  // of the finest level
constexpr double kLargestSteps = 1 << 24;                    // a float holds every integer up to here
constexpr int kTextureSteps = 65535;

/// The rules that a head keeps, written or read.
void check_digest(const std::string& digest) {
  const bool good = digest.size() <= 128 && std::all_of(digest.begin(), digest.end(), [](char c) {
                      return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                             c == '-' || c == '_' || c == ':' || c == '.';
                    });
  if (!good) throw FormatError("template digest has other characters than letters, digits and -_:.");
}

void check_steps(const HeadAssetOptions& steps) {
  const auto within = [](double step, double least) { return step >= least && step <= 10.0; };
  if (!within(steps.displacement_step_mm, 1e-5) || !within(steps.position_step_mm, 1e-4)) {
    throw FormatError("quantisation step is out of range");
  }
}

void check_triangles(const std::vector<Eigen::Vector3i>& triangles, std::size_t vertex_count) {
  if (triangles.empty()) throw FormatError("head has no triangles");
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int corner : triangles[t]) {
      if (corner < 0 || static_cast<std::size_t>(corner) >= vertex_count) {
        throw FormatError("corner " + std::to_string(corner) + " is no vertex (triangle " +
                          std::to_string(t) + ")");
      }
    }
  }
}

std::size_t count_edges(const std::vector<Eigen::Vector3i>& triangles) {
  std::vector<std::array<int, 2>> edges;
  edges.reserve(3 * triangles.size());
  for (const Eigen::Vector3i& corners : triangles) {
    for (int k = 0; k < 3; ++k) {
      edges.push_back(
          {std::min(corners[k], corners[(k + 1) % 3]), std::max(corners[k], corners[(k + 1) % 3])});
    }
  }
  std::sort(edges.begin(), edges.end());
  return static_cast<std::size_t>(std::unique(edges.begin(), edges.end()) - edges.begin());
}

/// Vertices of levels 0 .. level_count-1 under 1:4 splits. Refuses more than kMostVertices.
std::vector<std::size_t> level_sizes(const std::vector<Eigen::Vector3i>& triangles, std::size_t vertex_count,
                                     std::size_t level_count) {
  std::vector<std::size_t> sizes;
  std::size_t vertices = vertex_count, edges = count_edges(triangles), faces = triangles.size();
  for (std::size_t level = 0; level < level_count; ++level) {
    if (vertices > kMostVertices) throw FormatError("level " + std::to_string(level) + " is too fine");
    sizes.push_back(vertices);
    vertices += edges;
    edges = 2 * edges + 3 * faces;
    faces *= 4;
  }
  return sizes;
}

std::int32_t to_steps(double value, double step, const char* what, std::size_t idx) {
  const double steps = value / step;
  if (!(std::abs(steps) < kLargestSteps)) {
    throw FormatError(std::string(what) + " is not finite or too large (" + std::to_string(idx) + ")");
  }
  return static_cast<std::int32_t>(std::floor(steps + 0.5));
}

float from_steps(std::int32_t steps, double step) {
  return static_cast<float>(steps * step);
}

// ---- writing

LatticeMesh quantise(const HeadAsset& head, double step) {
  LatticeMesh mesh;
  mesh.triangles = head.triangles;
  for (std::size_t i = 0; i < head.positions.size(); ++i) {
    const auto coordinate = [&](int k) { return to_steps(head.positions[i][k], step, "position", i); };
    mesh.positions.emplace_back(coordinate(0), coordinate(1), coordinate(2));
    const Eigen::Vector2f& uv = head.uv[i];
    if (!(uv.minCoeff() >= 0.0f && uv.maxCoeff() <= 1.0f)) {
      throw FormatError("(u,v) is not in [0,1] (" + std::to_string(i) + ")");
    }
    const auto share = [](float value) { return static_cast<int>(double{value} * kTextureSteps + 0.5); };
    mesh.texture.emplace_back(share(uv.x()), kTextureSteps - share(uv.y()));  // glTF counts v downwards
  }
  return mesh;
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
    if (i >= first) steps.push_back(to_steps(values[i], step, "displacement", i));
  }
  return steps;
}

std::vector<std::int32_t> new_confidences(const HeadAsset& head, std::size_t level, std::size_t first) {
  const std::vector<std::uint8_t>& values = head.confidences[level];
  if (first > 0 && !std::equal(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(first),
                               head.confidences[level - 1].begin())) {
    throw FormatError("level " + std::to_string(level) +
                      " does not repeat the confidences of the level before");
  }
  return {values.begin() + static_cast<std::ptrdiff_t>(first), values.end()};
}

void check_sizes(const HeadAsset& head, const std::vector<std::size_t>& sizes) {
  if (head.uv.size() != head.positions.size()) throw FormatError("head has not one (u,v) per vertex");
  if (!head.confidences.empty() && head.confidences.size() != sizes.size()) {
    throw FormatError(std::to_string(head.confidences.size()) + " levels of confidences for " +
                      std::to_string(sizes.size()) + " of displacements");
  }
  for (std::size_t level = 0; level < sizes.size(); ++level) {
    const bool right = head.displacements_mm[level].size() == sizes[level] &&
                       (head.confidences.empty() || head.confidences[level].size() == sizes[level]);
    if (!right) {
      throw FormatError("level " + std::to_string(level) + " has not " + std::to_string(sizes[level]) +
                        " values");
    }
  }
}

/// Appends a stream to the BIN chunk, from a multiple of four bytes.
Stream append_stream(std::string& bin, const std::string& stream) {
  bin.append((4 - bin.size() % 4) % 4, '\0');
  bin += stream;
  return {bin.size() - stream.size(), stream.size()};
}

void write_mesh(const HeadAsset& head, Document& document, std::string& bin) {
  const double step = document.steps.position_step_mm;
  const LatticeMesh mesh = quantise(head, step);
  document.vertex_count = mesh.positions.size();
  document.triangle_count = mesh.triangles.size();
  document.mesh = append_stream(bin, encode_lattice_mesh(mesh, step));
  for (int k = 0; k < 3; ++k) {
    const auto [low, high] = std::minmax_element(mesh.positions.begin(), mesh.positions.end(),
                                                 [k](const auto& a, const auto& b) { return a[k] < b[k]; });
    document.low[k] = from_steps((*low)[k], step);
    document.high[k] = from_steps((*high)[k], step);
  }
}

void write_levels(const HeadAsset& head, const std::vector<std::size_t>& sizes, Document& document,
                  std::string& bin) {
  const double step = document.steps.displacement_step_mm;
  for (std::size_t level = 0; level < sizes.size(); ++level) {
    const std::size_t first = level == 0 ? 0 : sizes[level - 1];
    auto& entry = document.levels.emplace_back();
    entry.vertex_count = sizes[level];
    entry.displacements = append_stream(bin, encode_integers(new_displacements(head, level, first, step)));
    if (document.has_confidences) {
      entry.confidences = append_stream(bin, encode_integers(new_confidences(head, level, first)));
    }
  }
}

// ---- reading

std::vector<std::int32_t> read_stream(std::string_view bin, const Stream& stream, std::size_t count) {
  return decode_integers(bin.substr(stream.offset, stream.length), count);
}

void read_levels(std::string_view bin, const Document& document, HeadAsset& head) {
  const auto sizes = level_sizes(head.triangles, head.positions.size(), document.levels.size());
  for (std::size_t level = 0; level < sizes.size(); ++level) {
    const auto& entry = document.levels[level];
    if (entry.vertex_count != sizes[level]) {
      throw FormatError("level " + std::to_string(level) + " has not " + std::to_string(sizes[level]) +
                        " vertices");
    }
    const std::size_t first = level == 0 ? 0 : sizes[level - 1], count = sizes[level] - first;
    std::vector<float>& displacements = head.displacements_mm.emplace_back(first, 0.0f);
    displacements.reserve(sizes[level]);
    for (std::int32_t steps : read_stream(bin, entry.displacements, count)) {
      if (std::abs(static_cast<double>(steps)) > kLargestSteps)
        throw FormatError("displacement is too large");
      displacements.push_back(from_steps(steps, document.steps.displacement_step_mm));
    }
    if (!document.has_confidences) continue;
    std::vector<std::uint8_t> confidences;
    confidences.reserve(sizes[level]);
    if (level > 0) confidences = head.confidences.back();
    for (std::int32_t value : read_stream(bin, entry.confidences, count)) {
      if (value < 0 || value > 255) throw FormatError("confidence is no byte");
      confidences.push_back(static_cast<std::uint8_t>(value));
    }
    head.confidences.push_back(std::move(confidences));
  }
}

HeadAsset decode(std::string_view json, std::string_view bin) {
  const Document document = head_asset_document::parse(json, bin.size());
  check_digest(document.template_digest);
  check_steps(document.steps);
  if (!document.scan_from_head.allFinite()) throw FormatError("scan_from_head is not finite");
  if (document.vertex_count > kMostVertices || document.triangle_count > 2 * kMostVertices) {
    throw FormatError("head claims " + std::to_string(document.vertex_count) + " vertices");
  }
  const LatticeMesh mesh =
      decode_lattice_mesh(bin.substr(document.mesh.offset, document.mesh.length),
                          document.steps.position_step_mm, document.vertex_count, document.triangle_count);
  HeadAsset head;
  head.template_digest = document.template_digest;
  head.scan_from_head = document.scan_from_head;
  head.triangles = mesh.triangles;
  check_triangles(head.triangles, mesh.positions.size());
  for (const Eigen::Vector3i& q : mesh.positions) {
    if (q.cwiseAbs().maxCoeff() > kLargestSteps) throw FormatError("position is too large");
    const auto coordinate = [&](int k) { return from_steps(q[k], document.steps.position_step_mm); };
    head.positions.emplace_back(coordinate(0), coordinate(1), coordinate(2));
  }
  for (const Eigen::Vector2i& t : mesh.texture) {
    head.uv.emplace_back(from_steps(t.x(), 1.0 / kTextureSteps),
                         from_steps(kTextureSteps - t.y(), 1.0 / kTextureSteps));
  }
  read_levels(bin, document, head);
  return head;
}

}  // namespace

void write_head_asset(const HeadAsset& head, const HeadAssetOptions& options, std::ostream& out) {
  check_digest(head.template_digest);
  check_steps(options);
  check_triangles(head.triangles, head.positions.size());
  if (!head.scan_from_head.allFinite()) throw FormatError("scan_from_head is not finite");
  const auto sizes = level_sizes(head.triangles, head.positions.size(), head.displacements_mm.size());
  check_sizes(head, sizes);
  Document document;
  document.template_digest = head.template_digest;
  document.steps = options;
  document.scan_from_head = head.scan_from_head;
  document.has_confidences = !head.confidences.empty();
  std::string bin;
  write_mesh(head, document, bin);
  write_levels(head, sizes, document, bin);
  document.bin_length = bin.size();
  std::string bytes = join_glb(head_asset_document::format(document), bin);
  const std::size_t seal = head_asset_document::find_seal(bytes);
  bytes.replace(seal, head_asset_document::kSealLength,
                digest_without(bytes, seal, head_asset_document::kSealLength));
  write_all(out, bytes);
}

HeadAsset read_head_asset(std::istream& in) {
  const std::string bytes = read_all(in);
  const GlbChunks chunks = split_glb(bytes);
  const std::size_t seal = head_asset_document::find_seal(bytes);
  if (std::string_view(bytes).substr(seal, head_asset_document::kSealLength) !=
      digest_without(bytes, seal, head_asset_document::kSealLength)) {
    throw FormatError("is damaged: its content does not match its seal (byte " + std::to_string(seal) + ")");
  }
  try {
    return decode(chunks.json, chunks.bin);
  } catch (const std::bad_alloc&) {
    throw FormatError("claims more than memory holds");
  }
}

}  // namespace phiz
