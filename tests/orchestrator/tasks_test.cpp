// The tables of the real stages, and what tasks keep between two runs. No stage runs here.

#include "orchestrator/tasks/tasks.h"

#include <gtest/gtest.h>

#include <set>

#include "orchestrator/error.h"
#include "orchestrator/pipeline.h"
#include "orchestrator/tasks/fit_state.h"
#include "orchestrator/tasks/ingest_state.h"
#include "orchestrator/tasks/kept_outputs.h"
#include "orchestrator/work_journal.h"
#include "tests/store/memory_file_system.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

TEST(TaskTables, FormAPipelineFromScanToHead) {
  const Pipeline pipeline(list_task_tables());
  ASSERT_FALSE(pipeline.tasks().empty());
  EXPECT_EQ(pipeline.tasks().front().name, "ingest");
  const auto& last = pipeline.closure("").back()->outputs;
  EXPECT_NE(std::find(last.begin(), last.end(), "head.glb"), last.end());
}

TEST(TaskTables, EveryDefaultPassesItsOwnCheckAndSaysWhatItIs) {
  std::set<std::string> options;
  for (const Task& task : list_task_tables()) {
    EXPECT_FALSE(task.doc.empty()) << task.name;
    std::set<std::string> names;
    for (const Parameter& parameter : task.parameters) {
      const std::string label = task.name + "." + parameter.name;
      EXPECT_TRUE(names.insert(parameter.name).second) << label;
      EXPECT_FALSE(parameter.doc.empty()) << label;
      const std::string text = format_value(parameter.default_value);
      EXPECT_EQ(parse_value(parameter, text, label), parameter.default_value) << label;
      EXPECT_TRUE(parameter.option.empty() || options.insert(parameter.option).second) << label;
    }
    EXPECT_NO_THROW(make_key_text(task, resolve_parameters(task.parameters, task.name, {}), {})) << task.name;
  }
}

ControlPositions random_positions(int count) {
  ControlPositions positions;
  for (int i = 0; i < count; ++i) {
    positions.emplace_back(test::random().normal(), test::random().normal(), test::random().normal());
  }
  return positions;
}

GlobalFitState random_state(int vertex_count) {
  GlobalFitState state;
  state.round = 3;
  state.iteration = 1;
  state.eyes_shut = true;
  state.positions = random_positions(vertex_count);
  state.round_start = random_positions(vertex_count);
  state.energies = {0.1, 1.0 / 3, 1e300};
  return state;
}

TEST(FitState, ReadsBackBitForBit) {
  const GlobalFitState state = random_state(20);
  const auto read = decode_fit_state(encode_fit_state(state), 20);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->round, 3);
  EXPECT_EQ(read->iteration, 1);
  EXPECT_TRUE(read->eyes_shut);
  EXPECT_EQ(read->positions, state.positions);
  EXPECT_EQ(read->round_start, state.round_start);
  EXPECT_EQ(read->energies, state.energies);
}

TEST(FitState, NoTruncationAndNoOtherMeshIsTaken) {
  const std::string bytes = encode_fit_state(random_state(4));
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_FALSE(decode_fit_state(bytes.substr(0, length), 4)) << length;
  }
  EXPECT_FALSE(decode_fit_state(bytes + std::string(8, '\0'), 4));
  EXPECT_FALSE(decode_fit_state(bytes, 5));
}

IngestState random_ingest_state(bool has_normals) {
  IngestState state;
  for (int i = 0; i < 20; ++i) {
    const auto vector = [] { return Eigen::Vector3d::NullaryExpr([] { return test::random().normal(); }); };
    state.cloud.positions.push_back(vector().cast<float>());
    if (!has_normals) continue;
    state.cloud.normals.push_back(vector().cast<float>());
    state.cloud.confidences.push_back(0.5f);
    state.cloud.colours.push_back({1, 2, 3});
  }
  state.scan_from_head = Eigen::Matrix4d::Random();
  state.head_scale = 1.0 / 3;
  state.spacing_mm = 0.7f;
  state.summary.unit = "mm";
  state.summary.points_read = 10'000'000;
  state.summary.removed_far = 7;
  state.summary.density_per_mm2 = 1.0 / 7;
  return state;
}

TEST(IngestState, ReadsBackBitForBit) {
  for (const bool has_normals : {false, true}) {
    const IngestState state = random_ingest_state(has_normals);
    const auto read = decode_ingest_state(encode_ingest_state(state));
    ASSERT_TRUE(read);
    EXPECT_EQ(read->cloud.positions, state.cloud.positions);
    EXPECT_EQ(read->cloud.normals, state.cloud.normals);
    EXPECT_EQ(read->cloud.colours, state.cloud.colours);
    EXPECT_EQ(read->cloud.confidences, state.cloud.confidences);
    EXPECT_EQ(read->scan_from_head, state.scan_from_head);
    EXPECT_EQ(read->head_scale, state.head_scale);
    EXPECT_EQ(read->spacing_mm, state.spacing_mm);
    EXPECT_EQ(read->summary.unit, "mm");
    EXPECT_EQ(read->summary.points_read, state.summary.points_read);
    EXPECT_EQ(read->summary.removed_far, state.summary.removed_far);
    EXPECT_EQ(read->summary.density_per_mm2, state.summary.density_per_mm2);
    EXPECT_EQ(encode_ingest_state(*read), encode_ingest_state(state));
  }
}

TEST(IngestState, NoTruncationIsTaken) {
  const std::string bytes = encode_ingest_state(random_ingest_state(true));
  for (std::size_t length = 0; length < bytes.size(); ++length)
    EXPECT_FALSE(decode_ingest_state(bytes.substr(0, length))) << length;
  EXPECT_FALSE(decode_ingest_state(bytes + "x"));
}

/// A task's world with nothing but checkpoints and outputs.
class CheckpointContext final : public TaskContext {
 public:
  std::string read_input(const std::string&) override { return {}; }
  std::string describe_input(const std::string&) const override { return {}; }
  std::string scan_extension() const override { return {}; }
  Digest input_digest(const std::string&) const override { return {}; }
  Digest template_digest() const override { return {}; }
  Memo& memo() override { return memo_; }
  const ParameterValue& parameter(const std::string&) const override { return value_; }
  void write_output(const std::string& name, std::string bytes) override { outputs[name] = std::move(bytes); }
  void progress(double, std::optional<double>) override {}
  void note(const std::string&) override {}
  bool stop_requested() const override { return false; }
  std::optional<std::string> load_checkpoint() override { return checkpoint; }
  bool checkpoint_due(double) const override { return is_due; }
  void save_checkpoint(std::span<const std::byte> bytes) override {
    checkpoint = std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }

  std::map<std::string, std::string> outputs;
  std::optional<std::string> checkpoint;
  bool is_due = true;

 private:
  Memo memo_;
  ParameterValue value_;
};

TEST(KeptOutputs, OfAnInterruptedRunAreNotMadeAgain) {
  CheckpointContext context;
  KeptOutputs first(context);
  EXPECT_FALSE(first.write_kept("a.png"));
  first.write("a.png", std::string(1000, 'a'));
  first.write("b.png", "");
  context.is_due = false;
  first.write("c.png", "too little work to be saved");
  context.outputs.clear();
  KeptOutputs second(context);
  EXPECT_TRUE(second.write_kept("a.png"));
  EXPECT_TRUE(second.write_kept("b.png"));
  EXPECT_FALSE(second.write_kept("c.png"));
  EXPECT_EQ(context.outputs,
            (std::map<std::string, std::string>{{"a.png", std::string(1000, 'a')}, {"b.png", ""}}));
  context.checkpoint = "of another program";
  EXPECT_FALSE(KeptOutputs(context).write_kept("a.png"));
}

TEST(WorkJournal, GivesBackWhatWasKeptForTheSameWorkAndForgetsItAtTheEnd) {
  test::MemoryFileSystem disk;
  const Store store = Store::open_or_create(disk, "/store");
  const std::vector<double> numbers = {1.0 / 3, -0.0, 1e300};
  WorkJournal first(store, "learn from x");
  JournalSteps(first, "scan").keep("fit", numbers);
  WorkJournal same(store, "learn from x"), another(store, "learn from y");
  EXPECT_EQ(JournalSteps(same, "scan").find("fit"), numbers);
  EXPECT_FALSE(JournalSteps(same, "scan").find("second fit"));
  EXPECT_FALSE(JournalSteps(same, "another scan").find("fit"));
  EXPECT_FALSE(JournalSteps(another, "scan").find("fit"));
  same.forget();
  EXPECT_FALSE(JournalSteps(first, "scan").find("fit"));
  EXPECT_TRUE(disk.list_folder("/store/checkpoints").empty());
}

}  // namespace
}  // namespace phiz
