#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "orchestrator/commands/commands.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "orchestrator/subject_state.h"
#include "store/error.h"

namespace phiz {
namespace {

using nlohmann::ordered_json;

constexpr std::chrono::milliseconds kWatchPeriod{1000};
constexpr std::chrono::milliseconds kStopPeriod{50};

/// The first stage that is not done, with its state; "done" if there is none.
std::string describe(const std::vector<StageState>& states) {
  for (const StageState& state : states) {
    if (state.status != StageState::Status::kDone)
      return fmt::format("{} {}", state.stage, name_of(state.status));
  }
  return "done";
}

/// One line of the table, and whether every stage is done.
struct Line {
  std::string text;
  bool is_done = false;
};

std::string format_json(const SubjectRecord& record, const std::vector<StageState>& states) {
  ordered_json object = {{"type", "status"}, {"subject", record.name}, {"scan", record.scan_path}};
  object["scan_digest"] = record.scan_digest.hex();
  object["stages"] = ordered_json::array();
  for (const StageState& state : states) {
    ordered_json stage = {{"stage", state.stage}, {"status", name_of(state.status)}};
    if (state.key) {
      stage["key"] = state.key->hex();
      stage["seconds"] = state.seconds;
    }
    object["stages"].push_back(std::move(stage));
  }
  return object.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

Line make_line(const Session& session, const SubjectRecord& record, const std::vector<StageState>& states,
               std::size_t name_width) {
  const auto done = std::count_if(states.begin(), states.end(), [](const StageState& state) {
    return state.status == StageState::Status::kDone;
  });
  const bool is_done = static_cast<std::size_t>(done) == states.size();
  if (session.globals().is_json) return {format_json(record, states), is_done};
  return {fmt::format("{:<{}}  {}/{}  {:<20}  {}", record.name, name_width, done, states.size(),
                      describe(states), to_one_line(record.scan_path)),
          is_done};
}

/// A subject whose record cannot be read is a line too: one must not hide the others.
Line describe_subject(const Session& session, const Store& store, const std::string& name,
                      std::size_t name_width, const std::optional<StoreNames>& listed) {
  try {
    const auto record = store.find_subject(name);
    if (record) {
      const StoreNames* names = listed ? &*listed : nullptr;
      const auto states = look_at_subject_state(store, session.pipeline(), *record, names);
      return make_line(session, *record, states, name_width);
    }
  } catch (const StoreError& error) {
    const bool is_one_of_many = listed && error.fault() != StoreFault::kPermission;
    if (!is_one_of_many) throw;
    if (session.globals().is_json) {
      return {ordered_json{{"type", "status"}, {"subject", name}, {"error", to_one_line(error.what())}}.dump(
                  -1, ' ', false, ordered_json::error_handler_t::replace),
              false};
    }
    return {fmt::format("{:<{}}  -    {:<20}  {}", name, name_width, "record unreadable",
                        to_one_line(error.what())),
            false};
  }
  if (listed) return {};             // removed meanwhile
  session.get_subject(store, name);  // says that there is none
  return {};
}

struct Table {
  std::string text;
  std::size_t subjects = 0, done = 0;
};

Table make_table(const Session& session, const Store& store, std::vector<std::string> names) {
  std::optional<StoreNames> listed;
  if (names.empty()) {
    names = store.list_subjects();
    listed = store.list_names();
  }
  std::size_t name_width = 7;
  for (const std::string& name : names) name_width = std::max(name_width, name.size());
  std::vector<Line> lines(names.size());
  tbb::parallel_for(std::size_t{0}, names.size(), [&](std::size_t i) {
    lines[i] = describe_subject(session, store, names[i], name_width, listed);
  });
  Table table;
  if (!session.globals().is_json) {
    table.text = fmt::format("{:<{}}  {}  {:<20}  {}\n", "subject", name_width, "n/m", "state", "scan");
  }
  for (const Line& line : lines) {
    if (line.text.empty()) continue;
    table.text += line.text + "\n";
    ++table.subjects;
    table.done += line.is_done;
  }
  return table;
}

/// Prints the table whenever it has changed, until every subject is done or somebody stops it.
int watch(const std::vector<std::string>& names, Session& session, const Store& store) {
  const Environment& environment = session.environment();
  std::string shown;
  for (;;) {
    const Table table = make_table(session, store, names);
    if (table.text != shown) {
      const bool is_screen = environment.err_is_terminal && !session.globals().is_json;
      environment.out << (is_screen ? "\x1b[H\x1b[2J" : "") << table.text;
      if (!session.globals().is_json)
        environment.out << fmt::format("{} of {} subjects done\n", table.done, table.subjects);
      environment.out.flush();
      shown = table.text;
    }
    if (table.subjects > 0 && table.done == table.subjects) return kExitDone;
    for (auto waited = kStopPeriod; waited <= kWatchPeriod; waited += kStopPeriod) {
      environment.stop.throw_if_requested();
      std::this_thread::sleep_for(kStopPeriod);
    }
  }
}

struct StatusArguments {
  std::vector<std::string> names;
  bool is_watching = false;
};

int run_status(const StatusArguments& arguments, Session& session) {
  if (arguments.is_watching && session.environment().is_front)
    throw EngineNeeded();  // it says nothing before its end
  const Store store = session.open_store();
  if (arguments.is_watching) return watch(arguments.names, session, store);
  session.environment().out << make_table(session, store, arguments.names).text;
  return kExitDone;
}

}  // namespace

Command make_status_command() {
  Command command{"status", "what is done for each subject", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<StatusArguments>();
    options.add_positionals("SUBJECT", arguments->names, "subjects (default: all)");
    options.add_flag("--watch", arguments->is_watching,
                     "again whenever something changed, until all is done");
    return [arguments](Session& session) { return run_status(*arguments, session); };
  };
  return command;
}

}  // namespace phiz
