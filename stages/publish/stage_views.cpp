#include "stages/publish/stage_views.h"

#include <algorithm>
#include <limits>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/surface_index.h"
#include "stages/publish/screen.h"

namespace phiz {
namespace {

constexpr float kFrameMargin = 1.06f, kFarAway = 1.25f;  // times the box of all points, of nearly all
constexpr float kOffsetBandwidthMm = 0.8f;               // as the displacements are measured

Image draw_cell(const SheetRow& row, const SheetColumn& column, const SheetOptions& options) {
  CONTRACT((row.cloud != nullptr) != (row.mesh != nullptr));
  ViewOptions view;
  view.camera = column.camera;
  view.width = options.width;
  view.height = options.height;
  view.frame_mm = column.frame_mm;
  view.light = row.light;
  view.use_colours = row.use_colours;
  view.heat = row.heat;
  view.wireframe = row.wireframe;
  view.flat = row.flat;
  view.point_size_mm = row.point_size_mm;
  return row.cloud ? render_points(*row.cloud, view) : render_mesh(*row.mesh, view);
}

/// The box about its own centre, larger by a factor and never flat.
Eigen::AlignedBox3f grow(const Eigen::AlignedBox3f& box, float factor) {
  const Eigen::Vector3f half = (box.sizes() * (0.5f * factor)).cwiseMax(1e-3f);
  return Eigen::AlignedBox3f(box.center() - half, box.center() + half);
}

/// The picture cut, or filled with white, on its right.
Image set_width(const Image& picture, int width) {
  Image result;
  result.width = width;
  result.height = picture.height;
  result.pixels.assign(static_cast<std::size_t>(width) * picture.height, {255, 255, 255});
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < std::min(width, picture.width); ++x) result.at(x, y) = picture.at(x, y);
  }
  return result;
}

}  // namespace

std::vector<SheetColumn> make_round_columns(const PointCloud& cloud) {
  const Eigen::AlignedBox3f most = find_robust_box(cloud.positions);
  if (most.isEmpty()) throw InvalidInput("a cloud without points cannot be drawn");
  const Eigen::AlignedBox3f near = grow(most, kFarAway);
  Eigen::AlignedBox3f all = most;
  for (const Eigen::Vector3f& position : cloud.positions) {
    if (position.allFinite() && near.contains(position)) all.extend(position);
  }
  const Eigen::AlignedBox3f box = grow(all, kFrameMargin);
  std::vector<SheetColumn> columns;
  for (const char* name : {"front", "side", "threequarter", "back"}) {
    columns.push_back({name, find_camera(name).value(), box});
  }
  return columns;
}

Image draw_sheet(const std::vector<SheetRow>& rows, const std::vector<SheetColumn>& columns,
                 const SheetOptions& options) {
  std::vector<std::vector<Image>> pictures;
  std::vector<std::vector<std::string>> labels;
  int last_width = options.width;
  for (const SheetRow& row : rows) {
    pictures.emplace_back();
    labels.emplace_back();
    for (const SheetColumn& column : columns) {
      pictures.back().push_back(draw_cell(row, column, options));
      const bool is_first = labels.back().empty() && !row.label.empty();
      labels.back().push_back(is_first ? row.label + ", " + column.label : column.label);
      last_width = std::max(last_width, pictures.back().back().width);
    }
  }
  for (std::vector<Image>& row : pictures) {  // one legend a row, and nothing shifted by it
    for (std::size_t c = 0; c < row.size(); ++c) {
      row[c] = set_width(row[c], c + 1 < row.size() ? options.width : last_width);
    }
  }
  if (!options.extra.empty()) {
    pictures.push_back(options.extra);
    labels.push_back(options.extra_labels);
  }
  return contact_sheet(pictures, labels, options.title);
}

std::vector<float> compute_distances(const PointCloud& cloud, const TriangleMesh& surface, double most_mm) {
  const SurfaceIndex index(surface.positions, surface.triangles);
  const std::vector<SurfaceHit> hits = index.find_nearest(cloud.positions, most_mm);
  std::vector<float> distances(cloud.size(), static_cast<float>(most_mm));
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].triangle_idx >= 0) distances[i] = static_cast<float>(hits[i].distance);
    if (!cloud.positions[i].allFinite()) distances[i] = std::numeric_limits<float>::quiet_NaN();
  }
  return distances;
}

std::vector<float> compute_offsets(const TriangleMesh& mesh, const ScanSurface& scan, double most_mm) {
  if (mesh.normals.size() != mesh.positions.size()) throw InvalidInput("offsets of a mesh without normals");
  std::vector<float> offsets(mesh.vertex_count(), std::numeric_limits<float>::quiet_NaN());
  parallel_for(offsets.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const ScanSurface::Measurement measurement =
          scan.measure(mesh.positions[i], mesh.normals[i], kOffsetBandwidthMm, static_cast<float>(most_mm));
      if (measurement.confidence > 0) offsets[i] = std::abs(measurement.offset_mm);
    }
  });
  return offsets;
}

std::vector<Image> split_strip(const Image& strip, int count, int most_width) {
  if (count < 1 || strip.width < count || strip.height < 1 || most_width < 1)
    throw InvalidInput("a strip of pictures that cannot be split");
  const int width = strip.width / count,
            factor = std::min((width + most_width - 1) / most_width, strip.height);
  std::vector<Image> pictures(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    Image& picture = pictures[static_cast<std::size_t>(k)];
    picture.width = width / factor;
    picture.height = strip.height / factor;
    picture.pixels.resize(static_cast<std::size_t>(picture.width) * picture.height);
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        std::array<int, 3> sum = {};
        for (int s = 0; s < factor * factor; ++s) {
          const auto& pixel = strip.at(k * width + x * factor + s % factor, y * factor + s / factor);
          for (std::size_t c = 0; c < 3; ++c) sum[c] += pixel[c];
        }
        for (std::size_t c = 0; c < 3; ++c)
          picture.at(x, y)[c] = static_cast<std::uint8_t>(sum[c] / (factor * factor));
      }
    }
  }
  return pictures;
}

}  // namespace phiz
