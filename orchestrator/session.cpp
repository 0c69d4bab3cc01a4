#include "orchestrator/session.h"

#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "orchestrator/error.h"

namespace phiz {
namespace {

ReportOptions make_report_options(const Environment& environment, const GlobalOptions& globals) {
  const bool is_dumb = environment.find_variable("TERM").value_or("dumb") == "dumb";
  const bool has_terminal = environment.err_is_terminal && !is_dumb;
  const bool wants_no_colour = !environment.find_variable("NO_COLOR").value_or("").empty();
  return {globals.is_json, globals.is_quiet, globals.is_verbose, has_terminal,
          has_terminal && !wants_no_colour};
}

std::optional<std::string> find_non_empty(const Environment& environment, const std::string& name) {
  const auto value = environment.find_variable(name);
  return value && !value->empty() ? value : std::nullopt;
}

}  // namespace

Session::Session(const Environment& environment, GlobalOptions globals)
    : environment_(environment),
      globals_(std::move(globals)),
      reporter_(
          make_reporter(make_report_options(environment_, globals_), environment_.out, environment_.err)) {}

std::filesystem::path Session::store_path() const {
  if (globals_.store) return *globals_.store;
  return find_non_empty(environment_, "PHIZ_STORE").value_or("./phiz-store");
}

Store Session::open_store() const {
  return Store::open(files(), store_path());
}

Store Session::open_or_create_store() const {
  return Store::open_or_create(files(), store_path());
}

TemplateFiles Session::load_head(const std::optional<std::string>& path) const {
  if (path) return load_template(files(), *path);
  if (const auto variable = find_non_empty(environment_, "PHIZ_TEMPLATE"))
    return load_template(files(), *variable);
  const std::filesystem::path program = environment_.program_folder;  // bin, or libexec/phiz for the engine
  for (const std::filesystem::path& folder :
       {program / "../share/phiz/generic_head", program / "../../share/phiz/generic_head",
        std::filesystem::path(PHIZ_SOURCE_GENERIC_HEAD)}) {
    if (files().find_status(folder / "head.obj")) return load_template(files(), folder);
  }
  throw FormatError("the generic head that comes with phiz is not there",
                    "name one with --template FILE.obj or PHIZ_TEMPLATE");
}

void Session::print(const std::string& line) const {
  if (!globals_.is_json) environment_.out << line << '\n';
}

void Session::print_json(const nlohmann::ordered_json& object) const {
  if (globals_.is_json) {
    environment_.out << object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
  }
}

SubjectRecord Session::get_subject(const Store& store, const std::string& name) const {
  if (auto record = store.find_subject(name)) return std::move(*record);
  throw UsageError("the store has no subject '" + name + "'", "phiz status lists the subjects");
}

}  // namespace phiz
