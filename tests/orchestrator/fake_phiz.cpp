#include "tests/orchestrator/fake_phiz.h"

#include <chrono>
#include <csignal>
#include <thread>

#include "formats/error.h"
#include "orchestrator/app.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/error.h"
#include "stages/geometry/error.h"
#include "store/error.h"

namespace phiz::test {
namespace {

void begin(FakeStages& stages, const std::string& stage) {
  const std::lock_guard lock(stages.mutex);
  ++stages.runs[stage];
  stages.on_event("begin " + stage);
  if (stages.fail_at == stage) throw NumericalFailure("did not converge, as the test asked");
}

void run_read(FakeStages& stages, TaskContext& context) {
  begin(stages, "read");
  std::istringstream scan(context.read_input("scan"));
  std::string words;
  for (std::string word; scan >> word;) {
    if (word == "bad") throw FormatError(context.describe_input("scan") + ": a bad word (line 1)", "mend it");
    words += (context.flag("loud") ? word + "!" : word) + "\n";
  }
  context.note("units: " + context.text("units"));
  context.write_output("words.txt", words);
}

void run_join(FakeStages& stages, TaskContext& context) {
  begin(stages, "join");
  const std::string words = context.read_input("words.txt");
  std::string joined = context.read_input("template.obj");
  int step = 0;
  if (const auto saved = context.load_checkpoint()) {
    step = saved->at(0);
    joined = saved->substr(1);
  }
  stages.first_step = step;
  stages.on_event("resumed " + std::to_string(step));
  const int steps = context.whole("steps");
  for (; step < steps; ++step) {
    if (step == stages.stop_at_step) stages.stop.request(SIGINT);
    const std::string state = static_cast<char>(step) + joined;
    context.save_checkpoint(std::as_bytes(std::span(state)));
    stages.on_event("saved " + std::to_string(step));
    std::this_thread::sleep_for(std::chrono::milliseconds(stages.step_milliseconds));
    context.progress(static_cast<double>(step) / steps, context.number("weight") / (step + 1));
    joined += words;
  }
  context.write_output("joined.txt", joined);
}

void run_finish(FakeStages& stages, TaskContext& context) {
  begin(stages, "finish");
  const std::string joined = context.read_input("joined.txt");
  if (joined.find("blob") != std::string::npos) throw FitRejected("not a head", "scan a head");
  context.write_output("head.glb", "glTF" + joined + context.template_digest().hex());
  context.write_output("finish.json", "{\"scan_from_head\":[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}");
}

void run_look(FakeStages& stages, TaskContext& context) {
  begin(stages, "look");
  context.write_output("look.png", "picture of " + context.read_input("head.glb"));
}

}  // namespace

std::vector<Task> make_fake_tasks(FakeStages& stages) {
  Task read{"read", "splits the scan into words", "", 1, {}, {scan_input()}, {"words.txt"}, "", {}};
  read.parameters = {
      {"units", std::string("auto"), "", "unit of the scan", "", 0, 0, {"auto", "mm", "cm"}, "--units"},
      {"loud", false, "", "adds exclamation marks", "", 0, 0, {}, ""}};
  read.run = [&stages](TaskContext& context) { run_read(stages, context); };
  Task join{"join", "joins the words", "the test", 1, {}, {}, {"joined.txt"}, "", {}};
  join.inputs = {output_of("read", "words.txt"), template_mesh_input()};
  join.parameters = {{"steps", std::int64_t{3}, "", "how often", "measured", 1, 100, {}, ""},
                     {"weight", 0.5, "mm", "the weight", "paper, 4.3", 0, 10, {}, ""}};
  join.run = [&stages](TaskContext& context) { run_join(stages, context); };
  Task finish{"finish", "makes the head", "", 1, {}, {}, {"head.glb", "finish.json"}, "finish.json", {}};
  finish.inputs = {output_of("join", "joined.txt"), template_annotations_input()};
  finish.run = [&stages](TaskContext& context) { run_finish(stages, context); };
  Task look{"look", "pictures", "", 1, {}, {output_of("finish", "head.glb")}, {"look.png"}, "", {}, "--look"};
  look.run = [&stages](TaskContext& context) { run_look(stages, context); };
  return {look, finish, read, join};  // the pipeline finds the order
}

FakePhiz::FakePhiz() {
  disk.make_folders("/disk");
  add_file("/scans/a.xyz", "some words of a scan");
  add_file("/head/head.obj", "v 0 0 0\n");
  add_file("/head/head.json", "{}");
}

void FakePhiz::add_file(const std::string& path, const std::string& text) {
  disk.make_folders(std::filesystem::path(path).parent_path());
  disk.remove_file(path);
  disk.create_file(path, std::as_bytes(std::span(text)), FileSystem::Mode::kWritable);
  disk.sync_file(path);
  disk.sync_folder(std::filesystem::path(path).parent_path());
}

int FakePhiz::run_on(FileSystem& files, std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--store", "/disk/store"});
  stages.stop.request(0);
  processes.start_next();
  std::ostringstream out_stream, err_stream;
  std::vector<Task> tasks = make_fake_tasks(stages);
  if (is_front) {
    for (Task& task : tasks) task.run = nullptr;
  }
  const Pipeline pipeline(std::move(tasks));
  const std::vector<Command> commands = list_light_commands();
  const auto find_variable = [this](const std::string& name) -> std::optional<std::string> {
    if (name == "PHIZ_TEMPLATE" && !variables.contains(name)) return "/head";
    const auto found = variables.find(name);
    return found == variables.end() ? std::nullopt : std::optional(found->second);
  };
  const Environment environment{out_stream,  err_stream,    files, processes, pipeline, commands,
                                stages.stop, find_variable, {},    false,     is_front, run_child};
  const int code = run_phiz(arguments, environment);
  out = out_stream.str();
  err = err_stream.str();
  return code;
}

Digest FakePhiz::digest_of(const std::string& subject, const std::string& stage, const std::string& output) {
  const Store store = open_store();
  const auto record = store.find_subject(subject);
  return store.find_done_result(record->results.at(stage))->outputs.at(output).digest;
}

}  // namespace phiz::test
