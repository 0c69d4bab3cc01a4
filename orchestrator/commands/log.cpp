#include <memory>
#include <nlohmann/json.hpp>

#include "orchestrator/commands/commands.h"
#include "orchestrator/error_table.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "store/run_log.h"

namespace phiz {
namespace {

int run_log(const std::vector<std::string>& subjects, Session& session) {
  const Store store = session.open_store();
  for (const std::string& line : read_run_log(store)) {
    bool is_wanted = subjects.empty();
    for (const std::string& subject : subjects) {
      is_wanted = is_wanted || line.find(" " + subject + " ") != std::string::npos;
    }
    if (!is_wanted) continue;
    session.print(line);
    session.print_json({{"type", "log"}, {"text", line}});
  }
  return kExitDone;
}

}  // namespace

Command make_log_command() {
  Command command{"log", "what was computed and what failed, by time", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto subjects = std::make_shared<std::vector<std::string>>();
    options.add_positionals("SUBJECT", *subjects, "subjects (default: all)");
    return [subjects](Session& session) { return run_log(*subjects, session); };
  };
  return command;
}

}  // namespace phiz
