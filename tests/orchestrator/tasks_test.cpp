// The tables of the real stages, and what tasks keep between two runs. No stage runs here.

#include "orchestrator/tasks/tasks.h"

#include <gtest/gtest.h>

#include <set>

#include "orchestrator/error.h"
#include "orchestrator/pipeline.h"
#include "orchestrator/tasks/fit_state.h"
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

}  // namespace
}  // namespace phiz
