#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "orchestrator/commands/commands.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/object_reference.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "store/verify.h"

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

int run_verify(Session& session) {
  const Store store = session.open_store();
  const VerifyReport report =
      verify_store(store, [&](std::uint64_t) { session.environment().stop.throw_if_requested(); });
  for (const StoreDamage& damage : report.damages) print_damage(session, damage);
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
  if (report.ok()) return kExitDone;
  session.reporter().failure({}, {kExitDamaged, "the store was damaged; nothing damaged is used any more",
                                  "run phiz fit again for the subjects: what is missing is computed anew"});
  return kExitDamaged;
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
  Command verify{"verify", "read every byte of the store and check it; damaged files are set aside", {}, {}};
  verify.declare = [](OptionSet&, const Environment&) -> Command::Action { return run_verify; };
  return {"store",
          "look into the store",
          {},
          {ls, make_reference_command("path", "the file of an object (do not change it)", run_path),
           make_reference_command("cat", "write an object to stdout", run_cat), verify}};
}

}  // namespace phiz
