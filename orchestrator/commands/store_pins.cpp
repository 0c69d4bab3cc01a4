#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "orchestrator/commands/commands.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"

namespace phiz {
namespace {

/// SUBJECT (all its current results), SUBJECT/STAGE, or the key of a result.
std::vector<Digest> find_keys(const Session& session, const Store& store, const std::string& reference) {
  if (const auto key = parse_digest(reference)) return {*key};
  const std::size_t slash = reference.find('/');
  const SubjectRecord record = session.get_subject(store, reference.substr(0, slash));
  std::vector<Digest> keys;
  if (slash == std::string::npos) {
    for (const auto& [stage, key] : record.results) keys.push_back(key);
    return keys;
  }
  const std::string stage = reference.substr(slash + 1);
  const auto result = record.results.find(stage);
  if (result == record.results.end()) {
    throw UsageError("'" + record.name + "' has no result of a stage '" + stage + "'",
                     "phiz status " + record.name + " lists them");
  }
  return {result->second};
}

void tell(const Session& session, const std::string& what, const Digest& key, const std::string& stage) {
  session.print(fmt::format("{} {} {}", what, key.hex(), stage));
  session.print_json({{"type", "pin"}, {"what", what}, {"key", key.hex()}, {"stage", stage}});
}

std::string stage_of(const Store& store, const Digest& key) {
  const auto result = store.find_result(key);
  return result ? result->stage() : "(no such result)";
}

int run_pin(const std::vector<std::string>& references, Session& session) {
  const Store store = session.open_store();
  if (references.empty()) {
    for (const Digest& key : store.list_pins()) tell(session, "pinned", key, stage_of(store, key));
    return kExitDone;
  }
  std::vector<Digest> keys;
  for (const std::string& reference : references) {
    for (const Digest& key : find_keys(session, store, reference)) {
      if (!store.find_result(key)) throw UsageError("the store has no result " + key.hex());
      keys.push_back(key);
    }
  }
  for (const Digest& key : keys) {
    if (!session.globals().is_dry_run) store.pin(key);
    // A collector may have taken it away before it saw the pin.
    if (!store.find_result(key)) throw UsageError("result " + key.hex() + " was removed meanwhile");
    tell(session, session.globals().is_dry_run ? "would pin" : "pinned", key, stage_of(store, key));
  }
  return kExitDone;
}

int run_unpin(const std::vector<std::string>& references, Session& session) {
  const Store store = session.open_store();
  if (references.empty()) throw UsageError("nothing named", "phiz store pin lists what is pinned");
  const std::vector<Digest> pins = store.list_pins();
  for (const std::string& reference : references) {
    for (const Digest& key : find_keys(session, store, reference)) {
      const bool is_pinned = std::find(pins.begin(), pins.end(), key) != pins.end();
      if (is_pinned && !session.globals().is_dry_run) store.unpin(key);
      tell(session, is_pinned ? "unpinned" : "was not pinned", key, stage_of(store, key));
    }
  }
  return kExitDone;
}

Command make_command(const std::string& name, const std::string& summary,
                     int (*run)(const std::vector<std::string>&, Session&)) {
  Command command{name, summary, {}, {}};
  command.declare = [run](OptionSet& options, const Environment&) -> Command::Action {
    auto references = std::make_shared<std::vector<std::string>>();
    options.add_positionals("RESULT", *references, "SUBJECT, SUBJECT/STAGE or the key of a result");
    return [references, run](Session& session) { return run(*references, session); };
  };
  return command;
}

}  // namespace

std::vector<Command> list_pin_commands() {
  return {make_command("pin", "keep results whatever becomes of their subjects; without any: list those kept",
                       run_pin),
          make_command("unpin", "let gc remove them again once no subject needs them", run_unpin)};
}

}  // namespace phiz
