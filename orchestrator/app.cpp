#include "orchestrator/app.h"

#include <algorithm>

#include "orchestrator/command_line.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/report.h"
#include "orchestrator/session.h"

namespace phiz {
namespace {

/// An error outside any stage, from before or after the session.
void report_failure(const Failure& failure, bool is_json, const Environment& environment) {
  if (is_json) {
    make_json_reporter(environment.out)->failure({}, failure);
  } else {
    environment.err << format_failure({}, failure, false);
  }
}

int run_parsed(const ParsedCommandLine& parsed, const Environment& environment) {
  if (parsed.text) {
    if (environment.is_front) throw EngineNeeded();  // the engine knows all commands
    environment.out << *parsed.text;
    return kExitDone;
  }
  Session session(environment, parsed.globals);
  return parsed.action(session);
}

/// Results that did not reach stdout are not delivered.
int check_output(int code, const Environment& environment) {
  environment.out.flush();
  environment.err.flush();
  if (code != kExitDone || environment.out.good()) return code;
  environment.err << "error: cannot write to standard output\n";
  return kExitDisk;
}

}  // namespace

int run_phiz(std::span<const std::string> arguments, const Environment& environment) {
  bool is_json = std::count(arguments.begin(), arguments.end(), "--json") > 0;
  int code = kExitDone;
  try {
    ParsedCommandLine parsed;
    try {
      parsed = parse_command_line(arguments, environment);
    } catch (const UsageError&) {
      if (environment.is_front) throw EngineNeeded();
      throw;
    }
    is_json = parsed.globals.is_json;
    code = run_parsed(parsed, environment);
  } catch (const EngineNeeded&) {
    throw;
  } catch (...) {
    const Failure failure = describe_failure(std::current_exception());
    report_failure(failure, is_json, environment);
    code = failure.code;
  }
  if (is_json) environment.out << "{\"type\":\"exit\",\"code\":" << code << "}\n";
  return check_output(code, environment);
}

}  // namespace phiz
