#include <fmt/format.h>

#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "orchestrator/commands/commands.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/option_set.h"
#include "orchestrator/quantity.h"
#include "orchestrator/session.h"
#include "store/collect.h"
#include "store/error.h"
#include "store/pack.h"

namespace phiz {
namespace {

using nlohmann::ordered_json;

/// These may take long: they belong where signals are heeded and lines appear as they come.
void require_engine(const Session& session) {
  if (session.environment().is_front) throw EngineNeeded();
}

// gc -------------------------------------------------------------------------------------------------------

struct CollectArguments {
  std::optional<std::string> older_than, max_size;
};

int run_gc(const CollectArguments& arguments, Session& session) {
  require_engine(session);
  CollectOptions options;
  options.is_dry_run = session.globals().is_dry_run;
  if (arguments.max_size) options.max_bytes = parse_bytes(*arguments.max_size, "--max-size");
  if (arguments.older_than)
    options.older_than_seconds = parse_duration(*arguments.older_than, "--older-than");
  const Store store = session.open_store();
  LeaseTable leases(store, session.environment().processes);
  const CollectReport report =
      collect_garbage(store, leases, options, [&] { session.environment().stop.throw_if_requested(); });
  const char* const verb = options.is_dry_run ? "would remove" : "removed";
  for (const CollectReport::Item& item : report.removed) {
    if (options.is_dry_run || session.globals().is_verbose)
      session.print(fmt::format("{} {} ({})", verb, item.what, format_bytes(item.bytes)));
    session.print_json({{"type", options.is_dry_run ? "would_remove" : "removed"},
                        {"what", item.what},
                        {"bytes", item.bytes},
                        {"age_seconds", item.age_seconds}});
  }
  const std::uint64_t after = report.bytes_before - report.bytes_removed;
  session.print(fmt::format("{} {} files, {}; {} stay", verb, report.removed.size(),
                            format_bytes(report.bytes_removed), format_bytes(after)));
  session.print_json({{"type", "gc"},
                      {"files", report.removed.size()},
                      {"bytes_removed", report.bytes_removed},
                      {"bytes_left", after},
                      {"restored", report.restored},
                      {"dry_run", options.is_dry_run}});
  if (options.max_bytes && after > *options.max_bytes) {
    session.reporter().warning(
        {}, "the rest is needed or too young: the store stays above " + *arguments.max_size);
  }
  return kExitDone;
}

Command make_gc_command() {
  Command command{"gc", "remove what no subject needs any more; -n shows it", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<CollectArguments>();
    options.add_text("--older-than", arguments->older_than,
                     "only what has been there so long: 30d, 12h, 0s (default 14d)");
    options.add_text("--max-size", arguments->max_size,
                     "no more than it takes to come down to this size, the oldest first: 200G");
    return [arguments](Session& session) { return run_gc(*arguments, session); };
  };
  return command;
}

// stats ----------------------------------------------------------------------------------------------------

struct Amount {
  std::uint64_t files = 0, bytes = 0;
};

int run_stats(Session& session) {
  require_engine(session);
  const Store store = session.open_store();
  std::map<std::string, Amount> stages;
  Amount objects, results;
  for (const Digest& digest : store.list_objects()) {
    ++objects.files;
    objects.bytes += store.find_object_size(digest).value_or(0);
  }
  for (const Digest& key : store.list_results()) {
    session.environment().stop.throw_if_requested();
    ++results.files;
    const auto result = store.find_result(key);
    if (!result) continue;
    Amount& stage = stages[result->stage()];
    ++stage.files;
    for (const auto& [name, output] : result->outputs) stage.bytes += output.size_bytes;
  }
  LeaseTable leases(store, session.environment().processes);
  std::size_t living = 0, dead = 0;
  for (const LeaseTable::Entry& lease : leases.list()) ++(lease.is_dead ? dead : living);
  const std::size_t subjects = store.list_subjects().size();
  const std::size_t checkpoints = store.files().list_folder(store.layout().checkpoints()).size();
  session.print(fmt::format("subjects     {:>9}", subjects));
  session.print(fmt::format("results      {:>9}", results.files));
  session.print(fmt::format("objects      {:>9}  {}", objects.files, format_bytes(objects.bytes)));
  session.print(fmt::format("checkpoints  {:>9}", checkpoints));
  session.print(fmt::format("leases       {:>9}  {} of dead processes", living + dead, dead));
  ordered_json object = {{"type", "stats"},
                         {"subjects", subjects},
                         {"results", results.files},
                         {"objects", objects.files},
                         {"object_bytes", objects.bytes},
                         {"checkpoints", checkpoints},
                         {"leases", living + dead},
                         {"dead_leases", dead}};
  for (const auto& [stage, amount] : stages) {
    session.print(fmt::format("  {:<11}{:>9}  {}", stage, amount.files, format_bytes(amount.bytes)));
    object["stages"][stage] = {{"results", amount.files}, {"bytes", amount.bytes}};
  }
  session.print_json(object);
  return kExitDone;
}

// unlock, migrate ------------------------------------------------------------------------------------------

int run_unlock(bool takes_all, Session& session) {
  const Store store = session.open_store();
  LeaseTable leases(store, session.environment().processes);
  std::size_t removed = 0, kept = 0;
  for (const LeaseTable::Entry& lease : leases.list()) {
    const bool goes = lease.is_dead || takes_all;
    const std::string who = fmt::format("process {} on {}", lease.holder.pid, lease.holder.host);
    if (goes && !session.globals().is_dry_run) leases.break_lease(lease.key);
    ++(goes ? removed : kept);
    session.print((goes ? "unlocked " : "held ") + lease.key.hex() + " of " + who);
    session.print_json({{"type", "lease"},
                        {"key", lease.key.hex()},
                        {"host", lease.holder.host},
                        {"pid", lease.holder.pid},
                        {"dead", lease.is_dead},
                        {"unlocked", goes}});
  }
  session.print(fmt::format("{} unlocked, {} held by others", removed, kept));
  return kExitDone;
}

/// Records of older programs have no notes of their results: they get them.
int run_migrate(Session& session) {
  require_engine(session);
  const Store store = session.open_store();
  std::size_t changed = 0, seen = 0;
  for (const std::string& name : store.list_subjects()) {
    session.environment().stop.throw_if_requested();
    const auto record = store.find_subject(name);
    if (!record) continue;
    ++seen;
    SubjectRecord current = *record;
    for (const auto& [stage, key] : record->results) {
      if (record->find_note(stage) != nullptr) continue;
      if (const auto result = store.find_done_result(key)) current.set_current(stage, make_note(*result));
    }
    if (current == *record) continue;
    ++changed;
    if (!session.globals().is_dry_run) store.save_subject(current);
  }
  session.print(
      fmt::format("format version 1, the newest; {} of {} records {}", changed, seen,
                  session.globals().is_dry_run ? "would be brought up to date" : "brought up to date"));
  session.print_json({{"type", "migrate"}, {"format_version", 1}, {"subjects", seen}, {"changed", changed}});
  return kExitDone;
}

// pack, unpack ---------------------------------------------------------------------------------------------

int run_pack(const std::vector<std::string>& names, const std::string& output, Session& session) {
  require_engine(session);
  const Store store = session.open_store();
  if (names.empty()) throw UsageError("no subject named", "phiz store pack SUBJECT... -o FILE.tar");
  for (const std::string& name : names) session.get_subject(store, name);
  const std::filesystem::path path = std::filesystem::absolute(output);
  std::uint64_t bytes = 0;
  const auto check_stop = [&] { session.environment().stop.throw_if_requested(); };
  if (session.globals().is_dry_run) {
    pack_subjects(store, names, [&](std::string_view part) { bytes += part.size(), check_stop(); });
  } else {
    bytes = pack_to_file(store, names, path, check_stop);
  }
  session.print(fmt::format("{}: {} subjects, {}", path.string(), names.size(), format_bytes(bytes)));
  session.print_json({{"type", "pack"}, {"path", path.string()}, {"subjects", names}, {"bytes", bytes}});
  return kExitDone;
}

int run_unpack(const std::string& file, bool replaces, Session& session) {
  require_engine(session);
  const auto status = session.files().find_status(file);
  if (!status || status->kind != FileSystem::Kind::kFile) throw UsageError(file + ": no such file");
  if (session.globals().is_dry_run) throw UsageError("store unpack has no --dry-run", "tar -tf lists a pack");
  const Store store = session.open_or_create_store();
  try {
    const UnpackReport report = unpack_file(store, file, {replaces});
    for (const std::string& name : report.subjects) session.print(name);
    session.print(fmt::format("{} subjects, {} results, {} objects", report.subjects.size(), report.results,
                              report.objects));
    session.print_json({{"type", "unpack"},
                        {"subjects", report.subjects},
                        {"results", report.results},
                        {"objects", report.objects}});
  } catch (const StoreError& error) {
    if (error.fault() != StoreFault::kDamaged && error.fault() != StoreFault::kInvalidName) throw;
    session.reporter().failure({}, {kExitBadInput, file + ": " + to_one_line(error.what()), {}});
    return kExitBadInput;
  }
  return kExitDone;
}

}  // namespace

std::vector<Command> list_store_upkeep_commands() {
  Command stats{"stats", "how much there is, by stage", {}, {}};
  stats.declare = [](OptionSet&, const Environment&) -> Command::Action { return run_stats; };
  Command unlock{"unlock", "remove the leases of dead processes", {}, {}};
  unlock.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto takes_all = std::make_shared<bool>(false);
    options.add_flag("--all", *takes_all, "also those of living processes (they end well all the same)");
    return [takes_all](Session& session) { return run_unlock(*takes_all, session); };
  };
  Command migrate{"migrate", "bring a store of an older program up to date", {}, {}};
  migrate.declare = [](OptionSet&, const Environment&) -> Command::Action { return run_migrate; };
  Command pack{"pack", "some subjects and all they need in one file (a tar)", {}, {}};
  pack.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto names = std::make_shared<std::vector<std::string>>();
    auto output = std::make_shared<std::optional<std::string>>();
    options.add_positionals("SUBJECT", *names, "the subjects");
    options.add_text("-o,--output", *output, "the file");
    options.require("--output");
    return [names, output](Session& session) { return run_pack(*names, **output, session); };
  };
  Command unpack{"unpack", "take over the subjects of a pack, checked byte by byte", {}, {}};
  unpack.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto file = std::make_shared<std::string>();
    auto replaces = std::make_shared<bool>(false);
    options.add_positional("FILE", *file, "what phiz store pack made");
    options.add_flag("--replace", *replaces, "also subjects that are there with other results");
    return [file, replaces](Session& session) { return run_unpack(*file, *replaces, session); };
  };
  return {make_gc_command(), stats, unlock, migrate, pack, unpack};
}

}  // namespace phiz
