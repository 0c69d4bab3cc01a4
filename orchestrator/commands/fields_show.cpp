#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/error.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/commands/fields.h"
#include "orchestrator/commands/rig_files.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "stages/deform/deform.h"
#include "stages/geometry/normals.h"
#include "stages/geometry/parallel.h"
#include "stages/publish/views.h"

namespace phiz {
namespace {

struct ShowArguments {
  std::string rig;
  std::vector<std::string> subjects, controls, views;
  std::optional<std::string> output, head;
  std::vector<std::string> levels;
  std::optional<double> value;
  std::optional<int> columns, width;
  bool has_heat = false;
};

/// One subject at one level, ready to be posed.
struct Poser {
  std::string label;
  NeutralSurface neutral;
  std::vector<Eigen::Vector3i> triangles;
  std::unique_ptr<CompiledCascade> cascade;
};

Poser make_poser(const Deformation& rig, const ControlMesh& head, const HeadAsset* asset, int level) {
  const NeutralMaker maker(head, level);
  std::vector<Eigen::Vector3d> control = head.positions;
  std::vector<std::vector<float>> displacements;
  if (asset != nullptr) {
    for (std::size_t v = 0; v < control.size(); ++v) control[v] = asset->positions.at(v).cast<double>();
    displacements = asset->displacements_mm;
  }
  Poser poser;
  poser.neutral = maker.make(control, displacements);
  poser.triangles = maker.hierarchy().triangles(level);
  poser.cascade = std::make_unique<CompiledCascade>(rig, sample_fields(rig, poser.neutral.uv), poser.neutral);
  return poser;
}

TriangleMesh pose(const Poser& poser, const Deformation& rig, const std::string& control, double value) {
  std::vector<float> controls(rig.controls.size(), 0.0f);
  if (control != "neutral") {
    const int index = find_control(rig, control);
    if (index < 0) {
      const std::string nearest = find_nearest_control(rig, control);
      throw UsageError("the rig has no control '" + control + "'",
                       nearest.empty() ? "" : "the nearest is " + nearest);
    }
    controls[index] = static_cast<float>(value);
  }
  TriangleMesh mesh;
  mesh.triangles = poser.triangles;
  mesh.positions.resize(poser.cascade->point_count());
  poser.cascade->evaluate(parameters_of_controls(rig, controls), mesh.positions);
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& p : mesh.positions) positions.push_back(p.cast<double>());
  for (const Eigen::Vector3d& n : compute_vertex_normals(positions, mesh.triangles))
    mesh.normals.push_back(n.cast<float>());
  return mesh;
}

Eigen::AlignedBox3f face_box(const NeutralSurface& neutral) {
  Eigen::AlignedBox3d box;
  for (const auto& [name, place] : neutral.landmarks) {
    if (!name.starts_with("ear") && !name.starts_with("tragus")) box.extend(place);
  }
  const Eigen::Vector3d margin(14, 26, 10);
  return Eigen::AlignedBox3f((box.min() - margin).cast<float>(), (box.max() + margin).cast<float>());
}

Image draw(const Poser& poser, const Deformation& rig, const std::string& control, const std::string& view,
           const ShowArguments& arguments) {
  const auto camera = find_camera(view);
  if (!camera)
    throw UsageError("there is no view '" + view + "'", "front, side, threequarter, under and the like");
  const TriangleMesh mesh = pose(poser, rig, control, arguments.value.value_or(1));
  ViewOptions options;
  options.camera = *camera;
  options.width = arguments.width.value_or(300);
  options.height = options.width * 6 / 5;
  options.frame_mm = face_box(poser.neutral);
  if (arguments.has_heat) {
    HeatMap heat;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
      heat.values.push_back((mesh.positions[v] - poser.neutral.positions[v]).norm());
    heat.high = 10;
    heat.caption = "way, mm";
    options.heat = std::move(heat);
  }
  return render_mesh(mesh, options);
}

std::vector<int> parse_levels(const std::vector<std::string>& texts) {
  std::vector<int> levels;
  for (const std::string& text : texts) {
    if (text.size() != 1 || text[0] < '0' || text[0] > '6')
      throw UsageError("--level " + text + " is not from 0 to 6");
    levels.push_back(text[0] - '0');
  }
  return levels.empty() ? std::vector<int>{3} : levels;
}

/// A row a subject and level, or, of one subject, the controls in rows of `columns`.
void run_show(ShowArguments arguments, Session& session) {
  const std::vector<int> levels = parse_levels(arguments.levels);
  const TemplateFiles files = session.load_head(arguments.head);
  const ControlMesh head = load_control_mesh(files);
  const Deformation rig = load_rig(session, arguments.rig);
  check_same_template(rig.template_digest, files, arguments.rig);
  if (arguments.controls.empty()) {
    arguments.controls.push_back("neutral");
    for (const RigControl& control : rig.controls) arguments.controls.push_back(control.name);
  }
  if (arguments.views.empty()) arguments.views = {"front"};
  std::vector<std::vector<Image>> rows;
  std::vector<std::vector<std::string>> labels;
  std::vector<Image> cells;
  std::vector<std::string> names;
  const std::size_t per_subject = arguments.controls.size() * arguments.views.size();
  const auto add = [&](const std::string& subject, const HeadAsset* asset) {
    for (const int level : levels) {
      const Poser poser = make_poser(rig, head, asset, level);
      for (const std::string& control : arguments.controls) {
        for (const std::string& view : arguments.views) {
          session.environment().stop.throw_if_requested();
          cells.push_back(draw(poser, rig, control, view, arguments));
          names.push_back(fmt::format("{}{}{}", control, arguments.subjects.size() > 1 ? " " + subject : "",
                                      levels.size() > 1 ? fmt::format(" level {}", level) : ""));
        }
      }
    }
  };
  if (arguments.subjects.empty()) add("generic head", nullptr);
  if (!arguments.subjects.empty()) {
    const Store store = session.open_store();
    for (const std::string& subject : arguments.subjects) {
      const HeadAsset asset = load_fitted_head(session, store, subject);
      check_same_template(asset.template_digest, files, subject);
      add(subject, &asset);
    }
  }
  const std::size_t columns =
      arguments.columns.value_or(static_cast<int>(std::min<std::size_t>(per_subject, 9)));
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i % columns == 0) rows.emplace_back(), labels.emplace_back();
    rows.back().push_back(std::move(cells[i]));
    labels.back().push_back(names[i]);
  }
  std::ostringstream out;
  write_png(contact_sheet(rows, labels), out);
  if (!session.globals().is_dry_run) write_output_files(session, {{*arguments.output, std::move(out).str()}});
  session.print(*arguments.output);
  session.print_json({{"type", "picture"}, {"path", *arguments.output}});
}

}  // namespace

Command make_fields_show_command() {
  Command command{"show", "pictures of a rig's controls on the generic head or on fitted ones", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<ShowArguments>();
    options.add_positional("RIG", arguments->rig, "rig.json, with rig.exr beside it");
    options.add_text("-o,--output", arguments->output, "the .png");
    options.require("--output");
    options.add_texts("--subject", arguments->subjects,
                      "fitted heads of the store (default: the generic head)");
    options.add_texts("--control", arguments->controls, "controls to show, or neutral (default: all)");
    options.add_texts("--view", arguments->views, "front (default), side, threequarter, under ...");
    options.add_texts("--level", arguments->levels, "levels of subdivision, 0 to 6 (default 3)");
    options.add_number("--value", arguments->value, "of the control (default 1)");
    options.add_integer("--columns", arguments->columns, "pictures a row");
    options.add_integer("--width", arguments->width, "pixels of a picture (default 300)");
    options.add_flag("--heat", arguments->has_heat, "colour by the way each place goes");
    options.add_text("--template", arguments->head, "the generic head's .obj, its .json beside it");
    return [arguments](Session& session) {
      if (arguments->columns && *arguments->columns < 1) throw UsageError("--columns is below 1");
      if (arguments->width && (*arguments->width < 16 || *arguments->width > 4000))
        throw UsageError("--width is not from 16 to 4000");
      with_threads(session.globals().threads.value_or(0), [&] { run_show(*arguments, session); });
      return int{kExitDone};
    };
  };
  return command;
}

}  // namespace phiz
