#include "tests/bench/phiz_runs.h"

#include <stdlib.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <stdexcept>

namespace phiz::bench {
namespace {

using nlohmann::json;

void take_step(const json& object, SubjectRun& subject) {
  StageRun& stage = subject.stages[object.at("stage").get<std::string>()];
  stage.is_computed = object.at("status") == "computed";
  stage.seconds = object.value("seconds", 0.0);
  if (!object.contains("outputs")) return;
  for (const auto& [name, output] : object.at("outputs").items()) {
    stage.digests[name] = output.at("digest").get<std::string>();
  }
}

/// Reads the JSON lines of a run; the last line of a killed one may be cut.
class LineReader {
 public:
  explicit LineReader(FitRun& run) : run_(run) {}

  void read(const std::string& line) {
    const json object = json::parse(line, nullptr, /*allow_exceptions=*/false);
    if (!object.is_object() || !object.contains("subject")) return;
    const std::string name = object.at("subject").get<std::string>();
    const std::string type = object.value("type", "");
    SubjectRun& subject = run_.subjects[name];
    if (type == "step" && object.value("status", "") != "started") take_step(object, subject);
    if (type == "progress") take_progress(name, object, subject);
    if (type == "error") subject.error = object.value("what", "");
    if (type != "subject") return;
    subject.is_done = object.value("status", "") == "done";
    subject.code = object.value("code", 0);
    for (const json& step : object.value("steps", json::array())) {
      const double first = subject.stages[step.at("stage").get<std::string>()].first_fraction;
      take_step(step, subject);
      subject.stages[step.at("stage").get<std::string>()].first_fraction = first;
    }
  }

 private:
  void take_progress(const std::string& name, const json& object, SubjectRun& subject) {
    const std::string stage = object.at("stage").get<std::string>();
    if (has_progress_.insert(name + "/" + stage).second) {
      subject.stages[stage].first_fraction = object.value("fraction", 0.0);
    }
  }

  FitRun& run_;
  std::set<std::string> has_progress_;
};

}  // namespace

std::map<std::string, std::string> SubjectRun::digests() const {
  std::map<std::string, std::string> all;
  for (const auto& [name, stage] : stages) {
    for (const auto& [output, digest] : stage.digests) all[name + "/" + output] = digest;
  }
  return all;
}

FitRun run_fit(const std::vector<std::filesystem::path>& scans, const FitOptions& options) {
  std::vector<std::string> argv = {test::phiz_program().string(), "fit", "--json", "--store",
                                   options.store.string()};
  if (options.threads > 0) argv.insert(argv.end(), {"-j", std::to_string(options.threads)});
  argv.insert(argv.end(), options.arguments.begin(), options.arguments.end());
  for (const std::filesystem::path& scan : scans) argv.push_back(scan.string());
  test::ProgramOptions program_options;
  program_options.kill_after_s = options.kill_after_s;
  FitRun run;
  run.program = test::run_program(argv, program_options);
  LineReader reader(run);
  std::istringstream lines(run.program.out);
  for (std::string line; std::getline(lines, line);) reader.read(line);
  return run;
}

test::ProgramRun run_phiz(const std::filesystem::path& store, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), test::phiz_program().string());
  arguments.insert(arguments.end(), {"--store", store.string()});
  return test::run_program(arguments);
}

std::string read_object(const std::filesystem::path& store, const std::string& digest) {
  if (digest.size() < 3) throw std::runtime_error("an output without a digest");
  const std::filesystem::path file = store / "objects" / digest.substr(0, 2) / digest.substr(2);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  return {std::istreambuf_iterator<char>(in), {}};
}

ScratchFolder::ScratchFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "phiz-bench-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder can be made: " + name);
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace phiz::bench
