#include "stages/evaluate/evaluate.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/head_asset.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/commands/truth_files.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/object_reference.h"
#include "orchestrator/option_set.h"
#include "orchestrator/tasks/head_surface.h"
#include "orchestrator/tasks/nouns.h"
#include "stages/geometry/parallel.h"
#include "stages/synth/synth.h"

namespace phiz {
namespace {

using nlohmann::ordered_json;

struct EvaluateArguments {
  std::string subject;
  std::optional<std::string> truth, pose, other, other_truth, other_pose, labels, landmarks, head;
  std::optional<int> level;
};

/// A fit and its truth in the truth's frame.
struct FittedSubject {
  std::string name;
  TriangleMesh fitted, truth;
  std::vector<std::uint8_t> confidences;
  std::vector<Eigen::Vector3f> cloud;
  std::map<std::string, Eigen::Vector3d> true_landmarks;
  int level = 0;
};

void transform(const Eigen::Matrix4d& matrix, std::vector<Eigen::Vector3f>& positions) {
  for (Eigen::Vector3f& p : positions) {
    p = (matrix * p.cast<double>().homogeneous()).head<3>().cast<float>();
  }
}

FittedSubject load_subject(const EvaluateArguments& arguments, const std::string& name,
                           const std::string& truth, const std::optional<std::string>& pose_text,
                           const Session& session, const Store& store) {
  const auto read = [&](const std::string& output) {
    return store.read_object(find_referenced_object(session, store, name + "/" + output).digest);
  };
  FittedSubject subject;
  subject.name = name;
  subject.truth = read_truth_mesh(truth);
  TruthPose pose;
  if (pose_text) pose = read_truth_pose(*pose_text, name, session);
  subject.true_landmarks = std::move(pose.landmarks_mm);

  const std::string bytes = read("subdivide/head.glb");
  HeadAsset asset;
  with_place(name + "/head.glb", [&] {
    std::istringstream in(bytes);
    asset = read_head_asset(in);
  });
  const int finest = std::max(0, static_cast<int>(asset.displacements_mm.size()) - 1);
  subject.level = arguments.level.value_or(finest);
  if (subject.level < 0 || subject.level > finest) {
    throw UsageError(fmt::format("--level {} is not from 0 to {}", subject.level, finest));
  }
  subject.fitted = evaluate_head(bytes, {subject.level, false});
  if (subject.level < static_cast<int>(asset.confidences.size())) {
    subject.confidences = asset.confidences[subject.level];
  }
  with_place(name + "/cloud.vdb", [&] {
    std::istringstream in(read("ingest/cloud.vdb"));
    subject.cloud = read_vdb_points(in).positions;
  });
  const Eigen::Matrix4d truth_from_head = pose.truth_from_scan * asset.scan_from_head;
  transform(truth_from_head, subject.fitted.positions);
  transform(truth_from_head, subject.cloud);
  return subject;
}

/// Prints one line, or one JSON object, a figure.
class Sheet {
 public:
  Sheet(const Session& session, std::string subject, double diagonal_mm)
      : session_(session), subject_(std::move(subject)), diagonal_mm_(diagonal_mm) {
    session_.print(fmt::format("{:<52} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>9}", subject_ + ", mm", "count",
                               "mean", "median", "95 %", "99 %", "max", "mean, %"));
  }

  void add(const std::string& measure, const std::string& group, const ErrorStats& stats) const {
    const double percent = diagonal_mm_ > 0 ? 100 * stats.mean / diagonal_mm_ : 0;
    const std::string label = group.empty() ? measure : "  " + measure + ", " + group;
    session_.print(fmt::format("{:<52} {:>8} {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3f} {:>9.4f}", label,
                               stats.count, stats.mean, stats.median, stats.p95, stats.p99, stats.max,
                               percent));
    session_.print_json({{"type", "evaluate"},
                         {"subject", subject_},
                         {"measure", measure},
                         {"group", group},
                         {"count", stats.count},
                         {"mean_mm", stats.mean},
                         {"median_mm", stats.median},
                         {"p95_mm", stats.p95},
                         {"p99_mm", stats.p99},
                         {"max_mm", stats.max},
                         {"mean_percent", percent}});
  }

  void add(const std::string& measure, const std::string& kind, const StatsByName& stats) const {
    for (const auto& [name, figures] : stats) add(measure, kind.empty() ? name : kind + " " + name, figures);
  }

 private:
  const Session& session_;
  std::string subject_;
  double diagonal_mm_ = 0;
};

struct TemplateParts {
  ControlMesh head;
  std::unique_ptr<SubdivisionHierarchy> hierarchy;
  Regions regions;
};

TemplateParts load_parts(const EvaluateArguments& arguments, int level, std::size_t vertex_count,
                         const Session& session) {
  const TemplateFiles files = session.load_head(arguments.head);
  TemplateParts parts;
  std::istringstream mesh(files.mesh), annotations(files.annotations);
  with_place(files.mesh_path.string(), [&] { parts.head = read_control_mesh(mesh, annotations); });
  parts.hierarchy = std::make_unique<SubdivisionHierarchy>(
      parts.head.triangles, static_cast<int>(parts.head.positions.size()), level);
  if (static_cast<std::size_t>(parts.hierarchy->vertex_count(level)) != vertex_count) {
    throw UsageError("the subject was fitted with another generic head", "name that one with --template");
  }
  parts.regions = refine_regions(*parts.hierarchy, parts.head.annotations, level);
  return parts;
}

void add_landmarks(const FittedSubject& subject, const TemplateParts& parts, const Sheet& sheet) {
  std::map<std::string, Eigen::Vector3d> fitted;
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& p : subject.fitted.positions) positions.push_back(p.cast<double>());
  for (const auto& [name, point] : parts.head.annotations.landmarks) {
    const SurfacePoint fine = refine_surface_point(*parts.hierarchy, subject.level, point);
    fitted[name] = position_at(fine, subject.fitted.triangles, positions);
  }
  std::vector<double> errors;
  for (const auto& [name, error] : compute_landmark_errors(fitted, subject.true_landmarks)) {
    errors.push_back(error);
  }
  if (!errors.empty()) sheet.add("landmarks", "", compute_error_stats(errors));
}

void add_surface(const FittedSubject& subject, const TemplateParts& parts, const Regions& truth_regions,
                 const Sheet& sheet) {
  const SurfaceView fitted{subject.fitted.positions, subject.fitted.triangles},
      truth{subject.truth.positions, subject.truth.triangles};
  sheet.add("cloud to fitted", "", compute_error_stats(compute_distances(subject.cloud, fitted)));
  sheet.add("cloud to truth", "", compute_error_stats(compute_distances(subject.cloud, truth)));
  SurfaceErrorOptions options;
  options.truth_regions = truth_regions;
  const SurfaceErrors errors =
      compute_surface_errors(fitted, {parts.regions, subject.confidences}, truth, subject.cloud, options);
  sheet.add("seen truth to fitted", "", errors.truth_to_fitted);
  sheet.add("seen truth to fitted", "", errors.truth_to_fitted_by_region);
  sheet.add("seen truth to fitted", "truth", errors.truth_to_fitted_by_truth_region);
  sheet.add("seen truth to fitted", "", errors.truth_to_fitted_by_confidence);
  sheet.add("fitted to truth", "", errors.fitted_to_truth);
  sheet.add("fitted to truth", "", errors.fitted_to_truth_by_region);
  sheet.add("fitted to truth", "", errors.fitted_to_truth_by_confidence);
}

void add_correspondence(const FittedSubject& a, const FittedSubject& b, const TemplateParts& parts,
                        const Regions& truth_regions, const Sheet& sheet) {
  CorrespondenceOptions options;
  options.regions = parts.regions;
  options.truth_regions = truth_regions;
  const CorrespondenceErrors errors = compute_correspondence_errors(
      {a.fitted.positions, b.fitted.positions, a.truth.positions, b.truth.positions, a.truth.triangles},
      options);
  const std::string measure = "correspondence to " + b.name;
  sheet.add(measure, "", errors.all);
  sheet.add(measure, "", errors.by_region);
  sheet.add(measure, "truth", errors.by_truth_region);
}

void run(const EvaluateArguments& arguments, Session& session) {
  if (arguments.other.has_value() != arguments.other_truth.has_value()) {
    throw UsageError("--other and --other-truth belong together");
  }
  const Store store = session.open_store();
  FittedSubject subject =
      load_subject(arguments, arguments.subject, *arguments.truth, arguments.pose, session, store);
  const TemplateParts parts = load_parts(arguments, subject.level, subject.fitted.positions.size(), session);
  Regions truth_regions;
  if (arguments.labels) {
    truth_regions = read_truth_regions(*arguments.labels, subject.truth.positions.size(), session);
  }
  if (arguments.landmarks) {
    subject.true_landmarks = read_truth_landmarks(*arguments.landmarks, subject.truth, session);
  }
  const Sheet sheet(session, subject.name, compute_box_diagonal(subject.cloud));
  add_surface(subject, parts, truth_regions, sheet);
  add_landmarks(subject, parts, sheet);
  if (!arguments.other) return;
  const std::optional<std::string>& pose = arguments.other_pose ? arguments.other_pose : arguments.pose;
  const FittedSubject other =
      load_subject(arguments, *arguments.other, *arguments.other_truth, pose, session, store);
  add_correspondence(subject, other, parts, truth_regions, sheet);
}

}  // namespace

Command make_evaluate_command() {
  Command command{"evaluate", "errors of a fitted subject against the true surface", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<EvaluateArguments>();
    options.add_positional("SUBJECT", arguments->subject, "the subject");
    options.add_text("--truth", arguments->truth, "mesh of the true surface, mm");
    options.require("--truth");
    options.add_text("--truth-from-scan", arguments->pose,
                     "4x4 as [[...],...], or a JSON file: a 4x4, or scan_from_truth, or a subjects.json");
    options.add_text("--other", arguments->other, "another subject: correspondence is measured too");
    options.add_text("--other-truth", arguments->other_truth, "its truth, of the same indexing");
    options.add_text("--other-truth-from-scan", arguments->other_pose,
                     "its pose (default: --truth-from-scan)");
    options.add_text("--labels", arguments->labels, "JSON with ranges of the truth's vertices: regions");
    options.add_text("--landmarks", arguments->landmarks, "JSON with the truth's landmarks as vertices");
    options.add_integer("--level", arguments->level, "level of the fit (default: the finest)");
    options.add_text("--template", arguments->head, "the generic head's .obj, its .json beside it");
    return [arguments](Session& session) {
      with_threads(session.globals().threads.value_or(0), [&] { run(*arguments, session); });
      return int{kExitDone};
    };
  };
  return command;
}

}  // namespace phiz
