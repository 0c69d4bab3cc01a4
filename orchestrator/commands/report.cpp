#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/commands/report_page.h"
#include "orchestrator/commands/report_residuals.h"
#include "orchestrator/commands/rig_files.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/object_reference.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "orchestrator/subject_state.h"

namespace phiz {
namespace {

struct ReportArguments {
  std::vector<std::string> subjects;
  std::optional<std::string> output;
  bool is_all = false;
};

/// Bars of the surface's distance to its own scan, mm: beyond the first look twice, beyond the second look.
constexpr double kGoodMeanMm = 0.25, kPoorMeanMm = 0.6;

std::string judge(const SubjectReport& report) {
  for (const StageReport& stage : report.stages)
    if (stage.status != "done") return "not finished: " + stage.name + " " + stage.status;
  if (report.residuals.mean_mm > kPoorMeanMm) return "poor: far from its scan";
  return report.residuals.mean_mm > kGoodMeanMm ? "look: rougher than most" : "good";
}

StageReport describe_stage(const Store& store, const Pipeline& pipeline, const StageState& state,
                           SubjectReport& report) {
  StageReport stage{state.stage, name_of(state.status), state.seconds, 0, {}, {}, {}};
  if (!state.result) return stage;
  stage.peak_memory_bytes = state.result->run.peak_memory_bytes;
  stage.key_text = state.result->key_text.text();
  for (const auto& [name, object] : state.result->outputs) stage.outputs[name] = object.digest.hex();
  const std::string& summary = pipeline.get(state.stage).summary;
  const auto found = state.result->outputs.find(summary);
  if (found != state.result->outputs.end())
    stage.summary = nlohmann::ordered_json::parse(store.read_object(found->second.digest), nullptr, false);
  if (state.stage == "views" && state.status == StageState::Status::kDone) {
    for (const auto& [name, object] : state.result->outputs)
      if (name.ends_with(".png")) report.pictures[name] = store.read_object(object.digest);
  }
  return stage;
}

SubjectReport describe_subject(const Session& session, const Store& store, const std::string& name,
                               const ControlMesh& generic) {
  SubjectReport report;
  report.name = name;
  const SubjectRecord record = session.get_subject(store, name);
  report.scan_path = record.scan_path;
  report.scan_digest = record.scan_digest.hex();
  for (const StageState& state : compute_subject_state(store, session.pipeline(), record))
    report.stages.push_back(describe_stage(store, session.pipeline(), state, report));
  const auto read = [&](const char* output) {
    return store.read_object(find_referenced_object(session, store, name + "/" + output).digest);
  };
  try {
    measure_residuals(read("subdivide/head.glb"), read("ingest/cloud.vdb"), generic, report);
  } catch (const UsageError& error) {  // not fitted yet
    report.residuals.mean_mm = 0;
  }
  report.verdict = judge(report);
  return report;
}

int run_report(const ReportArguments& arguments, Session& session) {
  if (arguments.is_all != arguments.subjects.empty()) throw UsageError("either SUBJECT... or --all");
  const Store store = session.open_store();
  const std::vector<std::string> names = arguments.is_all ? store.list_subjects() : arguments.subjects;
  if (names.empty()) throw UsageError("the store has no subjects");
  const ControlMesh generic = load_control_mesh(session.load_head(std::nullopt));
  std::vector<SubjectReport> reports;
  for (const std::string& name : names) {
    session.environment().stop.throw_if_requested();
    reports.push_back(describe_subject(session, store, name, generic));
    const SubjectReport& report = reports.back();
    session.print(fmt::format("{}: {}, {:.3f} mm from its scan on average", name, report.verdict,
                              report.residuals.mean_mm));
    session.print_json({{"type", "report"},
                        {"subject", name},
                        {"verdict", report.verdict},
                        {"mean_mm", report.residuals.mean_mm},
                        {"p95_mm", report.residuals.p95_mm}});
  }
  std::stable_sort(reports.begin(), reports.end(), [](const SubjectReport& a, const SubjectReport& b) {
    return a.residuals.mean_mm > b.residuals.mean_mm;  // outliers first
  });
  const std::string page = make_report_page(reports);
  if (!session.globals().is_dry_run) write_output_files(session, {{*arguments.output, page}});
  session.print(fmt::format("{}: {} bytes", *arguments.output, page.size()));
  return kExitDone;
}

}  // namespace

Command make_report_command() {
  Command command{
      "report", "one page on fitted heads: verdict, pictures, distances, seconds, provenance", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<ReportArguments>();
    options.add_positionals("SUBJECT", arguments->subjects, "the subjects");
    options.add_flag("--all", arguments->is_all, "every subject of the store");
    options.add_text("-o,--output", arguments->output, "the page, an .html that needs no other file");
    options.require("--output");
    return [arguments](Session& session) { return run_report(*arguments, session); };
  };
  return command;
}

}  // namespace phiz
