#include "orchestrator/tasks/adapt.h"

#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/error.h"
#include "formats/gltf.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/commands/rig_files.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/object_reference.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "orchestrator/tasks/nouns.h"
#include "stages/geometry/parallel.h"
#include "stages/retarget/retarget.h"

namespace phiz {
namespace {

using nlohmann::ordered_json;

struct AdaptArguments {
  std::string subject;
  std::vector<std::string> criteria;
  std::optional<std::string> output, picture, changes, pose, motion, rig, base, blocks, norm, weight, eye,
      head;
  std::optional<int> frame, depth, first_level, vertices, level;
  std::optional<double> tolerance, degrees, seconds, pixels;
  bool is_animated = false;
};

/// What can be said of a criterion by its name; true: in order.
bool read_criterion(const std::string& name, CriterionOptions& options) {
  if (name == "uniform")
    options.criterion = Criterion::kUniform;
  else if (name == "normals")
    options.criterion = Criterion::kNormals;
  else if (name == "contour")
    options.criterion = Criterion::kContour;
  else if (name == "order")
    options.criterion = Criterion::kDistance;
  else
    throw UsageError("there is no criterion '" + name + "'", "uniform, normals, contour or order");
  return name == "order";
}

Eigen::Vector3f read_place(const std::string& text) {
  Eigen::Vector3f place;
  char comma = 0, rest = 0;
  std::istringstream in(text);
  in >> place[0] >> comma >> place[1] >> comma >> place[2];
  if (!in || in >> rest || !place.allFinite()) throw UsageError("--eye " + text + " is not X,Y,Z in mm");
  return place;
}

AdaptRequest read_request(const AdaptArguments& a) {
  AdaptRequest request;
  CriterionOptions& options = request.criterion;
  request.in_order = read_criterion(a.criteria.empty() ? "contour" : a.criteria[0], options);
  if (a.tolerance && !(*a.tolerance >= 0)) throw UsageError("--tolerance is below 0");
  options.tolerance = a.tolerance.value_or(request.in_order && a.vertices ? 0.0 : 1.0);
  if (request.in_order && !a.vertices && options.tolerance == 0)
    throw UsageError("--criterion order needs --budget or --tolerance");
  if (a.degrees) {
    if (!(*a.degrees > 0)) throw UsageError("--degrees is not above 0");
    options.is_pure_angle = true;
    options.tolerance = *a.degrees * EIGEN_PI / 180;
  }
  const std::string norm = a.norm.value_or("maximum");
  if (norm != "maximum" && norm != "average" && norm != "integral")
    throw UsageError("--norm " + norm + " is not maximum, average or integral");
  options.norm = norm == "maximum"   ? ContourNorm::kMaximum
                 : norm == "average" ? ContourNorm::kAverage
                                     : ContourNorm::kIntegral;
  options.depth = a.depth.value_or(options.depth);
  options.first_level = a.first_level.value_or(0);
  if (options.depth < 0 || options.depth > 24 || options.first_level < 0 || options.first_level > 24)
    throw UsageError("--depth and --first-level are from 0 to 24");
  if (a.vertices && *a.vertices < 1) throw UsageError("--budget is below 1");
  if (a.level && (*a.level < 0 || *a.level > 6)) throw UsageError("--level is not from 0 to 6");
  request.level = a.level;
  if (a.vertices) request.budget.vertices = *a.vertices;
  if (a.eye) {
    AdaptView view;
    view.eye_mm = read_place(*a.eye);
    view.pixels_per_radian = static_cast<float>(a.pixels.value_or(1000));
    options.view = view;
  }
  const std::string blocks = a.blocks.value_or("matching");
  if (blocks != "matching" && blocks != "longest")
    throw UsageError("--blocks " + blocks + " is not matching or longest");
  request.blocks = blocks == "matching" ? BlockOrder::kMatching : BlockOrder::kLongestFirst;
  return request;
}

/// {"jawOpen": 0.5}: a control or its alias, and its value.
std::vector<float> read_pose(const Session& session, const std::string& path, const Deformation& rig) {
  const ordered_json document = ordered_json::parse(read_input_file(session, path), nullptr, false);
  if (!document.is_object()) throw FormatError(path + ": is no JSON object of controls and values");
  std::vector<float> controls(rig.controls.size(), 0.0f);
  for (const auto& [name, value] : document.items()) {
    const int index = find_control(rig, name);
    if (index < 0) {
      const std::string nearest = find_nearest_control(rig, name);
      throw FormatError(path + ": the rig has no control '" + name + "'",
                        nearest.empty() ? "" : "the nearest is " + nearest);
    }
    if (!value.is_number()) throw FormatError(path + ": the value of " + name + " is no number");
    controls[index] = value.get<float>();
  }
  return parameters_of_controls(rig, controls);
}

std::string make_mesh_file(const std::string& path, const TriangleMesh& mesh) {
  const std::string extension = std::filesystem::path(path).extension().string();
  std::ostringstream out;
  if (extension == ".glb")
    write_glb(mesh, out);
  else if (extension == ".obj")
    write_obj(mesh, out);
  else if (extension == ".ply")
    write_ply(mesh, out);
  else
    throw UsageError("cannot write a '" + extension + "' file", "use .glb, .obj or .ply");
  return std::move(out).str();
}

/// One run of the command.
class AdaptRun {
 public:
  AdaptRun(const AdaptArguments& arguments, Session& session)
      : arguments_(arguments),
        session_(session),
        request_(read_request(arguments)),
        store_(session.open_store()) {
    if (arguments.output) make_mesh_file(*arguments.output, one_triangle());  // refuses unknown endings early
    const TemplateFiles files = session.load_head(arguments.head);
    head_ = load_control_mesh(files);
    asset_ = load_fitted_head(session, store_, arguments.subject);
    check_same_template(asset_.template_digest, files, arguments.subject);
    load_rig_and_motion(files);
    limit_time();
    const std::optional<BaseLayout> layout = find_layout(files);
    adapter_ = std::make_unique<HeadAdapter>(head_, asset_, layout ? &*layout : nullptr, request_);
    weigh();
    report_base();
  }

  int run() {
    if (arguments_.is_animated) {
      run_animation();
    } else {
      if (arguments_.pose) adapter_->pose(*rig_, read_pose(session_, *arguments_.pose, *rig_));
      if (track_) adapter_->pose(*rig_, track_->frame(arguments_.frame.value_or(0)));
      run_criteria();
    }
    write_output_files(
        session_, session_.globals().is_dry_run ? std::map<std::filesystem::path, std::string>{} : files_);
    return kExitDone;
  }

 private:
  static TriangleMesh one_triangle() {
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    return mesh;
  }

  void load_rig_and_motion(const TemplateFiles& files) {
    if (!arguments_.rig) return;
    rig_ = load_rig(session_, *arguments_.rig);
    check_same_template(rig_->template_digest, files, *arguments_.rig);
    if (!arguments_.motion) return;
    track_ = map_motion(*rig_, load_motion(session_, *arguments_.motion));
    if (static_cast<std::size_t>(arguments_.frame.value_or(0)) >= track_->frame_count())
      throw UsageError(fmt::format("--frame {}: the motion has {} frames", arguments_.frame.value_or(0),
                                   track_->frame_count()));
  }

  void limit_time() {
    const auto start = std::chrono::steady_clock::now();
    request_.budget.keep_going = [this, start] {
      session_.environment().stop.throw_if_requested();
      const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
      return !arguments_.seconds || passed.count() < *arguments_.seconds;
    };
  }

  /// `face`: the layout beside the generic head; `head`: none; else a file.
  std::optional<BaseLayout> find_layout(const TemplateFiles& files) const {
    const std::string base = arguments_.base.value_or("face");
    if (base == "head") return std::nullopt;
    const std::filesystem::path path =
        base == "face" ? files.mesh_path.parent_path() / "base.json" : std::filesystem::path(base);
    std::istringstream in(read_input_file(session_, path));
    BaseLayout layout;
    with_place(path.string(), [&] { layout = read_base_layout(in); });
    return layout;
  }

  void weigh() {
    const std::string weight = arguments_.weight.value_or("none");
    if (weight == "confidence") {
      adapter_->weigh_by_confidence();
    } else if (weight == "texture") {
      std::istringstream in(store_.read_object(
          find_referenced_object(session_, store_, arguments_.subject + "/ingest/cloud.vdb").digest));
      adapter_->weigh_by_texture(read_vdb_points(in));
    } else if (weight != "none") {
      throw UsageError("--weight " + weight + " is not none, confidence or texture");
    }
  }

  void report_base() {
    const CompliantMesh& made = adapter_->base_report();
    session_.print(fmt::format("base: {} vertices, {} triangles; compliant: {}, {}; {} pairs, {} alone",
                               adapter_->given_vertices(), adapter_->given_triangles(), made.vertex_count,
                               made.triangles.size(), made.pairs, made.border_singles + made.inside_singles));
    session_.print_json({{"type", "adapt_base"},
                         {"vertices", adapter_->given_vertices()},
                         {"triangles", adapter_->given_triangles()},
                         {"compliant_vertices", made.vertex_count},
                         {"compliant_triangles", made.triangles.size()}});
  }

  void report(const std::string& name, const AdaptedHead& head) {
    session_.print(fmt::format("{} {}: {} vertices, {} triangles, {} splits, {} welds{}", arguments_.subject,
                               name, head.mesh.vertex_count(), head.mesh.triangle_count(), head.report.splits,
                               head.report.welds, head.report.is_done ? "" : ", ended by a budget"));
    ordered_json line = {{"type", "adapt"},
                         {"subject", arguments_.subject},
                         {"criterion", name},
                         {"vertices", head.mesh.vertex_count()},
                         {"triangles", head.mesh.triangle_count()},
                         {"splits", head.report.splits},
                         {"welds", head.report.welds},
                         {"is_done", head.report.is_done}};
    if (name == "order") line["largest_error_mm"] = head.report.error;
    session_.print_json(line);
  }

  void run_criteria() {
    std::vector<std::string> names = arguments_.criteria;
    if (names.empty()) names = {"contour"};
    std::vector<AdaptedHead> heads;
    for (const std::string& name : names) {
      CriterionOptions options = request_.criterion;
      const bool in_order = read_criterion(name, options);
      heads.push_back(adapter_->run(options, in_order));
      report(name, heads.back());
    }
    if (arguments_.output) files_[*arguments_.output] = make_mesh_file(*arguments_.output, heads[0].mesh);
    if (!arguments_.picture) return;
    std::ostringstream out;
    write_png(draw_adapted(heads, names), out);
    files_[*arguments_.picture] = std::move(out).str();
  }

  void run_animation() {
    std::string lines;
    const AdaptedHead last = adapter_->animate(
        *rig_, track_->frame_count(), [&](std::size_t frame) { return track_->frame(frame); },
        [&](const AdaptedFrame& frame) {
          session_.environment().stop.throw_if_requested();
          session_.print(fmt::format("frame {}: {} vertices, {} splits, {} welds", frame.frame,
                                     frame.vertices, frame.splits, frame.welds));
          session_.print_json({{"type", "adapt_frame"},
                               {"frame", frame.frame},
                               {"vertices", frame.vertices},
                               {"triangles", frame.triangles},
                               {"splits", frame.splits},
                               {"welds", frame.welds}});
          if (arguments_.changes) lines += describe_changes(frame) + "\n";
        });
    report("contour", last);
    if (arguments_.output) files_[*arguments_.output] = make_mesh_file(*arguments_.output, last.mesh);
    if (arguments_.changes) files_[*arguments_.changes] = lines;
  }

  /// One line a frame: the operators in order, slots as StellarChange has them, so that an index list can
  /// follow.
  static std::string describe_changes(const AdaptedFrame& frame) {
    ordered_json changes = ordered_json::array();
    for (const StellarChange& s : frame.mesh->changes())
      changes.push_back({s.is_split ? "split" : "weld", s.vertex, s.a, s.b, s.c, s.d, s.f, s.n, s.g, s.m});
    return ordered_json({{"frame", frame.frame}, {"changes", changes}}).dump();
  }

  const AdaptArguments& arguments_;
  Session& session_;
  AdaptRequest request_;
  Store store_;
  ControlMesh head_;
  HeadAsset asset_;
  std::optional<Deformation> rig_;
  std::optional<ParameterTrack> track_;
  std::unique_ptr<HeadAdapter> adapter_;
  std::map<std::filesystem::path, std::string> files_;
};

void check_arguments(const AdaptArguments& a) {
  if ((a.pose || a.motion) && !a.rig)
    throw UsageError("--pose and --motion need --rig", "make one: phiz fields muscles -o rig");
  if (a.rig && !a.pose && !a.motion) throw UsageError("--rig goes with --pose or --motion");
  if (a.pose && a.motion) throw UsageError("--pose or --motion, not both");
  if (a.is_animated && (!a.motion || a.frame || a.picture || a.criteria.size() > 1))
    throw UsageError("--animate needs --motion and goes without --frame, --picture and a second --criterion");
  if (a.is_animated && !a.criteria.empty() && a.criteria[0] != "contour")
    throw UsageError("--animate follows --criterion contour");
  if (a.changes && !a.is_animated) throw UsageError("--changes goes with --animate");
  if (a.frame && *a.frame < 0) throw UsageError("--frame is below 0");
  if (a.output && a.criteria.size() > 1) throw UsageError("-o takes the mesh of one --criterion");
  if (a.pixels && (!a.eye || !(*a.pixels > 0))) throw UsageError("--pixels goes with --eye and is above 0");
  if (!a.output && !a.picture && !a.is_animated)
    throw UsageError("nothing to write", "-o mesh.glb or --picture sheet.png");
}

void declare_rest(OptionSet& options, AdaptArguments& a) {
  options.add_integer("--budget", a.vertices, "vertices at most");
  options.add_number("--seconds", a.seconds, "time for refinement at most");
  options.add_integer("--depth", a.depth, "levels of uniform, each doubles the triangles (default 3)");
  options.add_integer("--first-level", a.first_level,
                      "refined without asking down to this level (default 0)");
  options.add_integer("--level", a.level, "of the surface, 0 to 6 (default: the head's finest)");
  options.add_text("--base", a.base,
                   "face (113 authored points, default), head (the generic head) or a file");
  options.add_text("--blocks", a.blocks, "matching (default) or longest: how the base is made compliant");
  options.add_text("--weight", a.weight, "none, confidence or texture: where errors count more");
  options.add_text("--eye", a.eye, "X,Y,Z in mm: errors are seen from there, in pixels");
  options.add_number("--pixels", a.pixels, "of one radian, with --eye (default 1000)");
  options.add_text("--rig", a.rig, "rig.json, with rig.exr beside it");
  options.add_text("--pose", a.pose, "a .json of controls and values");
  options.add_text("--motion", a.motion, "a motion file");
  options.add_integer("--frame", a.frame, "of the motion (default 0)");
  options.add_flag("--animate", a.is_animated, "follow the motion frame after frame and say what changes");
  options.add_text("--changes", a.changes, "with --animate: every split and weld, a line of JSON a frame");
  options.add_text("--template", a.head, "the generic head's .obj, its .json beside it");
}

}  // namespace

Command make_adapt_command() {
  Command command{"adapt", "a mesh as fine as the surface needs it, neutral, posed or moving", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<AdaptArguments>();
    options.add_positional("SUBJECT", arguments->subject, "a fitted subject of the store");
    options.add_text("-o,--output", arguments->output, "mesh.glb, .obj or .ply");
    options.add_text("--picture", arguments->picture, "a .png: (u,v) mesh, mesh and head, a row a criterion");
    options.add_texts("--criterion", arguments->criteria, "uniform, normals, contour (default) or order");
    options.add_number("--tolerance", arguments->tolerance,
                       "mm; with --norm integral mm^3, with --eye pixels (default 1)");
    options.add_number("--degrees", arguments->degrees, "normals by the angle alone");
    options.add_text("--norm", arguments->norm, "of contour: maximum (default), average or integral");
    declare_rest(options, *arguments);
    return [arguments](Session& session) {
      check_arguments(*arguments);
      int code = kExitDone;
      with_threads(session.globals().threads.value_or(0),
                   [&] { code = AdaptRun(*arguments, session).run(); });
      return code;
    };
  };
  return command;
}

}  // namespace phiz
