#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "orchestrator/commands/commands.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/option_set.h"
#include "orchestrator/run.h"
#include "orchestrator/session.h"
#include "store/error.h"
#include "store/verify.h"

namespace phiz {
namespace {

void print_damage(const Session& session, const StoreDamage& damage) {
  session.print("damaged: " + to_one_line(damage.what + ": " + damage.cause));
  for (const std::string& use : damage.used_by) session.print("  used by " + use);
  if (!damage.set_aside_to.empty()) session.print("  set aside as " + damage.set_aside_to.string());
  session.print_json({{"type", "damage"},
                      {"what", damage.what},
                      {"cause", damage.cause},
                      {"used_by", damage.used_by},
                      {"set_aside_to", damage.set_aside_to.string()}});
}

/// The parameters that the subject's current results were made with, as far as they can be read.
Settings settings_of(const Store& store, const Pipeline& pipeline, const SubjectRecord& record) {
  Settings settings;
  for (const auto& [stage, key] : record.results) {
    const Task* task = pipeline.find(stage);
    const auto result = task != nullptr ? store.find_result(key) : std::nullopt;
    if (!result) continue;
    for (const KeyText::Entry& entry : result->key_text.entries()) {
      for (const Parameter& parameter : task->parameters) {
        if (entry.tag != "parameter" || entry.name != parameter.name) continue;
        settings[stage][entry.name] = parse_value(parameter, entry.value, stage + "." + entry.name);
      }
    }
  }
  return settings;
}

/// The generic head that the subject was fitted with, from the store; nothing if it is damaged or not there.
std::optional<TemplateFiles> find_head(const Store& store, const Pipeline& pipeline,
                                       const SubjectRecord& record) {
  std::optional<std::string> mesh, annotations;
  const auto read = [&](const ResultNote& note, const TaskInput& input) -> std::optional<std::string> {
    const auto digest = note.inputs.find(input.name);
    if (digest == note.inputs.end() || !store.find_object_size(digest->second)) return std::nullopt;
    return store.read_object(digest->second);
  };
  try {
    for (const auto& [stage, note] : record.notes) {
      const Task* task = pipeline.find(stage);
      if (task == nullptr) continue;
      for (const TaskInput& input : task->inputs) {
        if (input.kind == TaskInput::Kind::kTemplateMesh && !mesh) mesh = read(note, input);
        if (input.kind == TaskInput::Kind::kTemplateAnnotations && !annotations)
          annotations = read(note, input);
      }
    }
  } catch (const StoreError&) {
    return std::nullopt;
  }
  if (!mesh || !annotations) return std::nullopt;
  return make_template("template.obj", std::move(*mesh), std::move(*annotations));
}

/// A subject of which something is gone, with what it takes to compute it anew.
struct Repair {
  SubjectJob job;
  std::optional<TemplateFiles> head;
  std::vector<std::string> extra_stages;
};

std::vector<Repair> list_repairs(const Store& store, const Pipeline& pipeline) {
  std::vector<Repair> repairs;
  for (const std::string& name : store.list_subjects()) {
    const auto record = store.find_subject(name);
    if (!record) continue;
    bool is_whole = true;
    Repair repair{{name, record->scan_path, {}}, find_head(store, pipeline, *record), {}};
    for (const auto& [stage, key] : record->results) {
      is_whole = is_whole && store.find_done_result(key).has_value();
      const Task* task = pipeline.find(stage);
      if (task != nullptr && !task->option.empty()) repair.extra_stages.push_back(stage);
    }
    if (is_whole) continue;
    repair.job.settings = settings_of(store, pipeline, *record);
    repairs.push_back(std::move(repair));
  }
  return repairs;
}

/// The code that the repair ends with: done if every subject is whole again.
int repair(const Store& store, Session& session) {
  const std::vector<Repair> repairs = list_repairs(store, session.pipeline());
  if (repairs.empty()) return kExitDone;
  LeaseTable leases(store, session.environment().processes);
  const StopFlag& stop = session.environment().stop;
  int code = kExitDone;
  for (const Repair& one : repairs) {
    const TemplateFiles head = one.head ? *one.head : session.load_head({});
    RunOptions options;
    options.threads = session.globals().threads.value_or(0);
    options.extra_stages = one.extra_stages;
    const auto outcomes =
        run_subjects({one.job}, options, {store, leases, session.pipeline(), head, session.reporter(), stop});
    const int ended = exit_code_of(outcomes, 1, stop);
    if (ended != kExitDone) code = ended;
    stop.throw_if_requested();
  }
  return code;
}

int report_damage(const VerifyReport& report, bool has_marker_repaired, Session& session) {
  for (const StoreDamage& damage : report.damages) print_damage(session, damage);
  if (has_marker_repaired) session.print("phiz-store.json was damaged and has been written anew");
  session.print(
      fmt::format("{} objects, {} results, {} subjects, {:.1f} MB read: {}", report.objects, report.results,
                  report.subjects, static_cast<double>(report.bytes) / 1e6,
                  report.ok() ? "all as written" : fmt::format("{} damaged", report.damages.size())));
  session.print_json({{"type", "verify"},
                      {"objects", report.objects},
                      {"results", report.results},
                      {"subjects", report.subjects},
                      {"bytes", report.bytes},
                      {"damaged", report.damages.size()}});
  return report.ok() ? kExitDone : kExitDamaged;
}

bool is_subject(const StoreDamage& damage) {
  return damage.what.starts_with("subject ");
}

int run_verify(bool repairs, Session& session) {
  if (session.environment().is_front) throw EngineNeeded();  // long, and a repair needs the stages
  const bool has_marker_repaired = repairs && Store::repair_marker(session.files(), session.store_path());
  const Store store = session.open_store();
  const StopFlag& stop = session.environment().stop;
  const VerifyReport report = verify_store(store, [&](std::uint64_t) { stop.throw_if_requested(); });
  const int found = report_damage(report, has_marker_repaired, session);
  const std::size_t restored = repairs ? restore_flipped_bits(store) : 0;
  if (restored > 0) session.print(fmt::format("{} files of one flipped bit put back as they were", restored));
  const bool has_lost_a_subject =
      std::any_of(report.damages.begin(), report.damages.end(), [&](const StoreDamage& damage) {
        return is_subject(damage) &&
               !session.files().find_status(store.layout().subjects() / (damage.what.substr(8) + ".json"));
      });
  if (repairs) {
    const int code = repair(store, session);
    if (code != kExitDone || !has_lost_a_subject) return code;
  }
  if (found == kExitDone) return kExitDone;
  session.reporter().failure(
      {},
      {kExitDamaged, "the store was damaged; nothing damaged is used any more",
       has_lost_a_subject ? "run phiz fit again for the subjects: their results are kept"
                          : "phiz store verify --repair, or phiz fit for the subjects, computes it anew"});
  return kExitDamaged;
}

}  // namespace

Command make_verify_command() {
  Command command{"verify", "read every byte of the store and check it; damaged files are set aside", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto repairs = std::make_shared<bool>(false);
    options.add_flag("--repair", *repairs, "compute what was damaged or is missing anew");
    return [repairs](Session& session) { return run_verify(*repairs, session); };
  };
  return command;
}

}  // namespace phiz
