#include "orchestrator/command_line.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/option_set.h"
#include "orchestrator/version.h"

namespace phiz {
namespace {

class CliOptionSet final : public OptionSet {
 public:
  explicit CliOptionSet(CLI::App& app) : app_(app) {}

  void add_flag(const std::string& names, bool& target, const std::string& doc) override {
    app_.add_flag(names, target, doc);
  }
  void add_text(const std::string& names, std::optional<std::string>& target,
                const std::string& doc) override {
    app_.add_option(names, target, doc);
  }
  void add_integer(const std::string& names, std::optional<int>& target, const std::string& doc) override {
    app_.add_option(names, target, doc);
  }
  void add_number(const std::string& names, std::optional<double>& target, const std::string& doc) override {
    app_.add_option(names, target, doc);
  }
  void add_texts(const std::string& names, std::vector<std::string>& target,
                 const std::string& doc) override {
    app_.add_option(names, target, doc)
        ->expected(1)
        ->allow_extra_args(false)  // what follows is a word of its own: --set a.b=1 SCAN
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  }
  void require(const std::string& names) override { app_.get_option(names)->required(); }
  void add_positional(const std::string& name, std::string& target, const std::string& doc) override {
    app_.add_option(name, target, doc)->required()->option_text(" ");
  }
  void add_positionals(const std::string& name, std::vector<std::string>& target,
                       const std::string& doc) override {
    app_.add_option(name, target, doc)->option_text("...");
  }

 private:
  CLI::App& app_;
};

void add_globals(CLI::App& app, GlobalOptions& globals) {
  app.add_option("--store", globals.store, "the store (default $PHIZ_STORE, else ./phiz-store)");
  app.add_option("-j,--threads", globals.threads, "threads to use (default: all)")
      ->check(CLI::Range(1, 4096));
  app.add_option("--max-memory", globals.max_memory,
                 "memory to use, such as 4G: fewer subjects at a time (default: no bound)");
  app.add_flag("--json", globals.is_json,
               "JSON lines on stdout, the last is {\"type\":\"exit\",\"code\":...}");
  app.add_flag("-q,--quiet", globals.is_quiet, "errors and results only");
  app.add_flag("-v,--verbose", globals.is_verbose, "say why each stage is computed");
  app.add_flag("-n,--dry-run", globals.is_dry_run, "say what would be done, change nothing");
}

std::string describe_exit_codes() {
  std::string text = "Exit codes:\n";
  for (const ExitCode& exit_code : exit_codes()) {
    const std::string number = std::to_string(exit_code.code);
    text += "  " + number + std::string(5 - number.size(), ' ') + exit_code.meaning + "\n";
  }
  return text;
}

/// Declares a command and its children. `chosen` becomes the action of the command the user names.
void declare(CLI::App& parent, const Command& command, const Environment& environment,
             Command::Action& chosen) {
  CLI::App* app = parent.add_subcommand(command.name, command.summary);
  app->fallthrough();
  app->footer("Options of every command, and exit codes: phiz --help\n");
  for (const Command& child : command.children) declare(*app, child, environment, chosen);
  if (!command.children.empty()) {
    app->require_subcommand(1);
    return;
  }
  CliOptionSet options(*app);
  app->callback([&chosen, action = command.declare(options, environment)] { chosen = action; });
}

/// The innermost command the user has named so far.
struct NamedCommand {
  const CLI::App* app;
  std::string parents;  // "phiz store"
};

NamedCommand find_deepest(const CLI::App& root) {
  NamedCommand command{&root, ""};
  while (!command.app->get_subcommands().empty()) {
    command.parents += (command.parents.empty() ? "" : " ") + command.app->get_name();
    command.app = command.app->get_subcommands().front();
  }
  return command;
}

}  // namespace

ParsedCommandLine parse_command_line(std::span<const std::string> arguments, const Environment& environment) {
  ParsedCommandLine parsed;
  CLI::App app("From raw 3D head scans to animatable head assets.", "phiz");
  app.footer(describe_exit_codes());
  app.set_version_flag("--version", std::string("phiz ") + kVersion);
  app.set_config("--config", "", "read options from a TOML file")->check(CLI::ExistingFile);
  app.allow_config_extras(CLI::config_extras_mode::error);
  app.require_subcommand(1);
  add_globals(app, parsed.globals);
  for (const Command& command : environment.commands) declare(app, command, environment, parsed.action);
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
  try {
    app.parse(reversed);
  } catch (const CLI::CallForVersion& version) {
    parsed.text = std::string(version.what()) + "\n";
  } catch (const CLI::Success&) {
    const NamedCommand asked = find_deepest(app);
    parsed.text = asked.app->help(asked.parents);
  } catch (const CLI::Error& error) {
    const NamedCommand asked = find_deepest(app);
    const std::string parents = asked.parents.empty() ? "" : asked.parents + " ";
    throw UsageError(error.what(), "see " + parents + asked.app->get_name() + " --help");
  }
  return parsed;
}

}  // namespace phiz
