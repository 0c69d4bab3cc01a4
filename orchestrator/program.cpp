#include "orchestrator/program.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <sstream>

#include "orchestrator/app.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/signals.h"

namespace phiz {
namespace {

std::vector<std::string> to_strings(int argc, char** argv) {
  return {argv + std::min(argc, 1), argv + argc};
}

std::optional<std::string> find_variable(const std::string& name) {
  const char* value = std::getenv(name.c_str());
  return value != nullptr ? std::optional<std::string>(value) : std::nullopt;
}

std::filesystem::path find_program_folder() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
}

/// Only returns if there is no engine to become.
int become_engine(char** argv) {
  const std::filesystem::path folder = find_program_folder();
  for (const std::filesystem::path& engine :
       {folder / "phiz-engine", folder / "../libexec/phiz/phiz-engine"}) {
    ::execv(engine.c_str(), argv);
    if (errno != ENOENT) break;
  }
  std::cerr << "error: cannot start phiz-engine: " << std::strerror(errno)
            << "\nhint: it belongs beside phiz, in " << folder.string() << "\n";
  return kExitFailed;
}

}  // namespace

int run_engine(int argc, char** argv, std::vector<Task> tasks, std::vector<Command> commands) {
  const std::vector<std::string> arguments = to_strings(argc, argv);
  const bool is_json = std::count(arguments.begin(), arguments.end(), "--json") > 0;
  const StopFlag& stop = install_stop_signals(is_json);
  const Pipeline pipeline(std::move(tasks));
  const Environment environment{
      std::cout, std::cerr, real_file_system(), real_processes(),      pipeline,
      commands,  stop,      find_variable,      find_program_folder(), ::isatty(STDERR_FILENO) == 1,
      false};
  return run_phiz(arguments, environment);
}

int run_front(int argc, char** argv, std::vector<Task> tables, std::vector<Command> light_commands) {
  std::ostringstream out, err;  // kept back: if the engine takes over, nothing has been said
  const StopFlag never;
  const Pipeline pipeline(std::move(tables));
  const Environment environment{out,
                                err,
                                real_file_system(),
                                real_processes(),
                                pipeline,
                                light_commands,
                                never,
                                find_variable,
                                find_program_folder(),
                                false,
                                true};
  try {
    const int code = run_phiz(to_strings(argc, argv), environment);
    std::cout << out.str() << std::flush;
    std::cerr << err.str() << std::flush;
    return code == kExitDone && !std::cout.good() ? kExitDisk : code;
  } catch (const EngineNeeded&) {
    return become_engine(argv);
  }
}

}  // namespace phiz
