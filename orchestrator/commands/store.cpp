#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "orchestrator/commands/commands.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/object_reference.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"

namespace phiz {
namespace {

using nlohmann::ordered_json;

int run_ls(std::vector<std::string> names, Session& session) {
  const Store store = session.open_store();
  if (names.empty()) names = store.list_subjects();
  for (const std::string& name : names) {
    const SubjectRecord record = session.get_subject(store, name);
    for (const auto& [stage, key] : record.results) {
      const auto result = store.find_result(key);
      if (!result) continue;
      for (const auto& [output, object] : result->outputs) {
        session.print(
            fmt::format("{} {:>10} {}/{}/{}", object.digest.hex(), object.size_bytes, name, stage, output));
        session.print_json({{"type", "object"},
                            {"subject", name},
                            {"stage", stage},
                            {"output", output},
                            {"bytes", object.size_bytes},
                            {"digest", object.digest.hex()},
                            {"key", key.hex()}});
      }
    }
  }
  return kExitDone;
}

int run_path(const std::string& reference, Session& session) {
  const Store store = session.open_store();
  const OutputObject object = find_referenced_object(session, store, reference);
  const std::string path = store.layout().object(object.digest).string();
  session.print(path);
  session.print_json({{"type", "path"}, {"digest", object.digest.hex()}, {"path", path}});
  return kExitDone;
}

int run_cat(const std::string& reference, Session& session) {
  if (session.globals().is_json) throw UsageError("store cat writes the object's bytes and has no --json");
  const Store store = session.open_store();
  session.environment().out << store.read_object(find_referenced_object(session, store, reference).digest);
  return kExitDone;
}

Command make_reference_command(const std::string& name, const std::string& summary,
                               int (*run)(const std::string&, Session&)) {
  Command command{name, summary, {}, {}};
  command.declare = [run](OptionSet& options, const Environment&) -> Command::Action {
    auto reference = std::make_shared<std::string>();
    options.add_positional("OBJECT", *reference, "SUBJECT/OUTPUT, SUBJECT/STAGE/OUTPUT or a digest");
    return [reference, run](Session& session) { return run(*reference, session); };
  };
  return command;
}

}  // namespace

Command make_store_command() {
  Command ls{"ls", "digest, size and name of every current output", {}, {}};
  ls.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto names = std::make_shared<std::vector<std::string>>();
    options.add_positionals("SUBJECT", *names, "subjects (default: all)");
    return [names](Session& session) { return run_ls(*names, session); };
  };
  Command store{"store",
                "look into the store and keep it in order",
                {},
                {ls, make_reference_command("path", "the file of an object (do not change it)", run_path),
                 make_reference_command("cat", "write an object to stdout", run_cat), make_verify_command()}};
  for (Command& child : list_store_upkeep_commands()) store.children.push_back(std::move(child));
  for (Command& child : list_pin_commands()) store.children.push_back(std::move(child));
  return store;
}

}  // namespace phiz
