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

/// The subject's former result of the stage, newest first; nothing if there is none or its file is gone.
std::optional<Result> find_former(const Store& store, const SubjectRecord& record, const std::string& stage) {
  for (auto past = record.history.rbegin(); past != record.history.rend(); ++past) {
    if (past->stage == stage) return store.find_result(past->key);
  }
  return std::nullopt;
}

ordered_json to_json(const std::optional<std::string>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

std::string describe(const KeyDifference& difference) {
  return "  " + difference.tag + " " + difference.name + ": " + difference.before.value_or("(none)") +
         " -> " + difference.after.value_or("(none)");
}

int run_why(const std::string& subject, const std::string& stage, Session& session) {
  const Store store = session.open_store();
  session.pipeline().get(stage);
  const SubjectRecord record = session.get_subject(store, subject);
  for (const StageState& state : compute_subject_state(store, session.pipeline(), record)) {
    if (state.stage != stage) continue;
    ordered_json object = {
        {"type", "why"}, {"subject", subject}, {"stage", stage}, {"status", name_of(state.status)}};
    session.print(subject + " " + stage + ": " + name_of(state.status));
    if (state.result) {
      session.print("computed because: " + state.result->run.reason);
      session.print("key " + state.result->key().hex());
      object["reason"] = state.result->run.reason;
      object["key"] = state.result->key().hex();
      object["key_text"] = state.result->key_text.text();
      if (const auto former = find_former(store, record, stage)) {
        session.print("differs from the former result " + former->key().hex() + ":");
        object["former_key"] = former->key().hex();
        object["differences"] = ordered_json::array();
        for (const KeyDifference& difference : compare_keys(former->key_text, state.result->key_text)) {
          session.print(describe(difference));
          object["differences"].push_back({{"tag", difference.tag},
                                           {"name", difference.name},
                                           {"before", to_json(difference.before)},
                                           {"after", to_json(difference.after)}});
        }
      }
    }
    session.print_json(object);
  }
  return kExitDone;
}

}  // namespace

Command make_why_command() {
  Command command{
      "why", "why a stage was computed for a subject, and what changed since the former result", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto words = std::make_shared<std::pair<std::string, std::string>>();
    options.add_positional("SUBJECT", words->first, "the subject");
    options.add_positional("STAGE", words->second, "the stage");
    return [words](Session& session) { return run_why(words->first, words->second, session); };
  };
  return command;
}

}  // namespace phiz
