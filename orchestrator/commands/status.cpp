#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "orchestrator/commands/commands.h"
#include "orchestrator/error_table.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "orchestrator/subject_state.h"

namespace phiz {
namespace {

using nlohmann::ordered_json;

/// The first stage that is not done, with its state; "done" if there is none.
std::string describe(const std::vector<StageState>& states) {
  for (const StageState& state : states) {
    if (state.status != StageState::Status::kDone)
      return fmt::format("{} {}", state.stage, name_of(state.status));
  }
  return "done";
}

void print_subject(const Session& session, const Store& store, const SubjectRecord& record,
                   std::size_t name_width) {
  const std::vector<StageState> states = compute_subject_state(store, session.pipeline(), record);
  const auto done = std::count_if(states.begin(), states.end(), [](const StageState& state) {
    return state.status == StageState::Status::kDone;
  });
  session.print(fmt::format("{:<{}}  {}/{}  {:<20}  {}", record.name, name_width, done, states.size(),
                            describe(states), to_one_line(record.scan_path)));
  if (!session.globals().is_json) return;
  ordered_json object = {{"type", "status"}, {"subject", record.name}, {"scan", record.scan_path}};
  object["scan_digest"] = record.scan_digest.hex();
  object["stages"] = ordered_json::array();
  for (const StageState& state : states) {
    ordered_json stage = {{"stage", state.stage}, {"status", name_of(state.status)}};
    if (state.result) {
      stage["key"] = state.result->key().hex();
      stage["seconds"] = state.result->run.seconds;
    }
    object["stages"].push_back(std::move(stage));
  }
  session.print_json(object);
}

int run_status(std::vector<std::string> names, Session& session) {
  const Store store = session.open_store();
  if (names.empty()) names = store.list_subjects();
  std::size_t name_width = 7;
  for (const std::string& name : names) name_width = std::max(name_width, name.size());
  session.print(fmt::format("{:<{}}  {}  {:<20}  {}", "subject", name_width, "n/m", "state", "scan"));
  for (const std::string& name : names)
    print_subject(session, store, session.get_subject(store, name), name_width);
  return kExitDone;
}

}  // namespace

Command make_status_command() {
  Command command{"status", "what is done for each subject", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto names = std::make_shared<std::vector<std::string>>();
    options.add_positionals("SUBJECT", *names, "subjects (default: all)");
    return [names](Session& session) { return run_status(*names, session); };
  };
  return command;
}

}  // namespace phiz
