#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <sstream>

#include "orchestrator/tasks/head_surface.h"
#include "orchestrator/tasks/kept_outputs.h"
#include "orchestrator/tasks/nouns.h"
#include "orchestrator/tasks/stages.h"
#include "stages/geometry/normals.h"
#include "stages/publish/stage_views.h"

namespace phiz {
namespace {

constexpr float kCloseUpPointMm = 1.5f;
constexpr int kSmoothLevel = 2;  // of the surface of a control mesh, as the global fit measures it

using Positions = std::vector<Eigen::Vector3d>;

TriangleMesh make_mesh(const Positions& positions, const std::vector<Eigen::Vector3i>& triangles) {
  TriangleMesh mesh;
  mesh.triangles = triangles;
  for (const Eigen::Vector3d& position : positions) mesh.positions.push_back(position.cast<float>());
  for (const Eigen::Vector3d& normal : compute_vertex_normals(positions, triangles))
    mesh.normals.push_back(normal.cast<float>());
  return mesh;
}

/// Where one looks closely: regions of the generic head, by name.
struct CloseUp {
  const char* region;
  Camera camera;
};
constexpr CloseUp kCloseUps[] = {
    {"ear_right", {-75, 0}}, {"eyes", {0, 0}}, {"nose", {0, -35}}, {"lips", {15, 5}}, {"ear_left", {75, 0}}};

/// Draws the sheets of one subject. What each needs is loaded when it is drawn.
class SheetMaker {
 public:
  explicit SheetMaker(TaskContext& context)
      : context_(context),
        kept_(context),
        head_(load_generic_head(context)),
        hierarchy_(load_hierarchy(context, kSmoothLevel)),
        cloud_(load_cloud(context, "cloud.vdb")),
        columns_(make_round_columns(cloud_)) {
    options_.width = context.whole("width_px");
    options_.height = options_.width * 11 / 9;
  }

  void draw_ingest() {
    if (kept_.write_kept("ingest.png")) return;
    std::vector<SheetRow> rows = {cloud_row("clean cloud"), cloud_row("grazing light")};
    rows[1].light = Light::kSide;
    if (cloud_.has_confidences()) {
      rows.push_back(cloud_row("confidence"));
      rows.back().heat = HeatMap{cloud_.confidences, 1, 0, ColourMap::kSequential, "0 to 1"};
    }
    if (cloud_.has_colours()) {
      rows.push_back(cloud_row("colours"));
      rows.back().use_colours = true;
      rows.back().light = Light::kNone;
    }
    save_sheet("ingest", "the clean cloud", rows);
  }

  void draw_align() {
    if (kept_.write_kept("align.png")) return;
    Eigen::Affine3d head_from_model;
    head_from_model.matrix() = matrix_from_json(load_json(context_, "alignment.json").at("head_from_model"));
    Positions aligned = head_->positions;
    for (Eigen::Vector3d& position : aligned) position = head_from_model * position;
    std::istringstream bytes(context_.read_input("silhouettes.png"));
    Image strip;
    with_place(context_.describe_input("silhouettes.png"), [&] { strip = read_png(bytes); });
    options_.extra = split_strip(strip, 3, options_.width);
    options_.extra_labels = {"grey: both", "red: scan alone", "blue: head alone"};
    draw_control("align", "generic head, aligned", aligned, false);
    options_.extra.clear();
    options_.extra_labels.clear();
  }

  void draw_local() {
    if (kept_.write_kept("fit_local.png")) return;
    draw_control("fit_local", "features placed", load_control_positions(context_, "local.obj"), false);
  }

  void draw_global() {
    if (kept_.write_kept("fit_global.png")) return;
    draw_control("fit_global", "control mesh", load_control_positions(context_, "control.obj"), true);
  }

  void draw_head() {
    const bool has_sheet = kept_.write_kept("subdivide.png");
    if (has_sheet && kept_.write_kept("closeups.png")) return;
    const TriangleMesh mesh = evaluate_head(context_.read_input("head.glb"), {});
    context_.progress(0.7);
    const double high = context_.number("heat_high_mm");
    const auto scan = load_scan_surface(context_, "cloud.vdb");
    std::vector<SheetRow> rows = {cloud_row("scan"), mesh_row("head", mesh), cloud_row("scan to head"),
                                  mesh_row("head to scan", mesh)};
    rows[2].heat = distance_map(compute_distances(cloud_, mesh, 2 * high), high);
    rows[3].heat = distance_map(compute_offsets(mesh, *scan, 2 * high), high);
    if (!has_sheet) save_sheet("subdivide", "the head; grey: not scanned", rows);
    context_.progress(0.9);
    draw_close_ups(rows);
  }

 private:
  SheetRow cloud_row(const char* label) const {
    SheetRow row;
    row.label = label;
    row.cloud = &cloud_;
    return row;
  }

  static SheetRow mesh_row(const char* label, const TriangleMesh& mesh) {
    SheetRow row;
    row.label = label;
    row.mesh = &mesh;
    return row;
  }

  static HeatMap distance_map(std::vector<float> distances, double high) {
    return {std::move(distances), 0, static_cast<float>(high), ColourMap::kSequential, "mm"};
  }

  /// The scan, the control mesh or its smooth surface, and the distances of the scan's points to the latter.
  void draw_control(const char* stage, const char* label, const Positions& control, bool as_wires) {
    const double high = context_.number(as_wires ? "heat_high_mm" : "early_heat_high_mm");
    const TriangleMesh smooth = make_mesh(evaluate_surface(*hierarchy_, control, {}, kSmoothLevel),
                                          hierarchy_->triangles(kSmoothLevel));
    const TriangleMesh plain = as_wires ? make_mesh(control, head_->triangles) : TriangleMesh{};
    std::vector<SheetRow> rows = {cloud_row("scan"), mesh_row(label, as_wires ? plain : smooth),
                                  cloud_row("scan to surface")};
    rows[1].wireframe = rows[1].flat = as_wires;
    if (as_wires) rows.insert(rows.begin() + 2, mesh_row("its smooth surface", smooth));
    rows.back().heat = distance_map(compute_distances(cloud_, smooth, 2 * high), high);
    save_sheet(stage, label, rows);
  }

  /// The rows of the head's sheet, and the head under grazing light, at the features.
  void draw_close_ups(std::vector<SheetRow> rows) {
    const Positions control = load_control_positions(context_, "control.obj");
    std::vector<SheetColumn> columns;
    for (const CloseUp& place : kCloseUps) {
      const auto region = head_->annotations.regions.find(place.region);
      if (region == head_->annotations.regions.end() || region->second.empty()) continue;
      Eigen::AlignedBox3f box;
      for (const int vertex_idx : region->second) box.extend(control[vertex_idx].cast<float>());
      columns.push_back({place.region, place.camera, box});
    }
    if (columns.empty()) columns = columns_;  // a generic head that names no regions
    rows.insert(rows.begin() + 2, rows[1]);
    rows[2].label = "grazing light";
    rows[2].light = Light::kSide;
    for (SheetRow& row : rows) row.point_size_mm = kCloseUpPointMm;
    SheetOptions options = options_;
    options.height = options.width;
    options.title = "closeups";
    save_picture("closeups.png", draw_sheet(rows, columns, options));
  }

  void save_sheet(const std::string& stage, const std::string& what, const std::vector<SheetRow>& rows) {
    options_.title = stage + ": " + what;
    save_picture(stage + ".png", draw_sheet(rows, columns_, options_));
  }

  void save_picture(const std::string& output, const Image& picture) {
    std::ostringstream out;
    write_png(picture, out);
    kept_.write(output, std::move(out).str());
  }

  TaskContext& context_;
  KeptOutputs kept_;
  std::shared_ptr<const ControlMesh> head_;
  std::shared_ptr<const SubdivisionHierarchy> hierarchy_;
  PointCloud cloud_;
  std::vector<SheetColumn> columns_;
  SheetOptions options_;
};

}  // namespace

void run_views(TaskContext& context) {
  SheetMaker maker(context);
  maker.draw_ingest();
  context.progress(0.2);
  maker.draw_align();
  context.progress(0.35);
  maker.draw_local();
  context.progress(0.45);
  maker.draw_global();
  context.progress(0.6);
  maker.draw_head();
  context.progress(1);
}

}  // namespace phiz
