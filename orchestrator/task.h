#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orchestrator/memo.h"
#include "orchestrator/parameter.h"
#include "store/digest.h"

namespace phiz {

/// What a running task sees of the world: its inputs, its parameters, a place for its outputs. Tasks see no
/// paths of the store, no clock and no other subject. Calls may come from the task's own thread only, except
/// progress() and stop_requested().
class TaskContext {
 public:
  virtual ~TaskContext() = default;

  // Inputs by the names in the task's table. Bytes are checked against their digests.
  virtual std::string read_input(const std::string& name) = 0;
  virtual std::string describe_input(
      const std::string& name) const = 0;          ///< for messages: a path, or "stage/output"
  virtual std::string scan_extension() const = 0;  ///< ".ply", lower case; part of the key
  virtual Digest input_digest(const std::string& name) const = 0;
  virtual Digest template_digest() const = 0;
  virtual Memo& memo() = 0;  ///< shared by the stages of this subject in this run

  // Parameters by name. A wrong name or type is a bug.
  virtual const ParameterValue& parameter(const std::string& name) const = 0;
  bool flag(const std::string& name) const { return std::get<bool>(parameter(name)); }
  int whole(const std::string& name) const {
    return static_cast<int>(std::get<std::int64_t>(parameter(name)));
  }
  double number(const std::string& name) const { return std::get<double>(parameter(name)); }
  const std::string& text(const std::string& name) const { return std::get<std::string>(parameter(name)); }

  /// Every output of the table exactly once, before the task returns.
  virtual void write_output(const std::string& name, std::string bytes) = 0;

  /// fraction in [0,1] of this stage; residual in the stage's own unit. Cheap; call as often as you like.
  /// Throws Interrupted if the user asked to stop: call it at safe points.
  virtual void progress(double fraction, std::optional<double> residual = {}) = 0;

  /// One line the user should read: what was assumed, what was removed. No part of the outputs.
  virtual void note(const std::string& line) = 0;

  /// For code that must not be left by an exception.
  virtual bool stop_requested() const = 0;

  // Checkpoints: the latest state saved under this very key, and a way to save one. Saving costs two syncs,
  // so ask checkpoint_due() first (true when so many seconds of work would be lost; more for a large state).
  virtual std::optional<std::string> load_checkpoint() = 0;
  virtual bool checkpoint_due(double seconds = 0.25) const = 0;
  virtual void save_checkpoint(std::span<const std::byte> bytes) = 0;
};

struct TaskInput {
  enum class Kind { kScan, kTemplateMesh, kTemplateAnnotations, kOutput };
  std::string name;  ///< what the task calls it
  Kind kind = Kind::kScan;
  std::string stage, output;  ///< of kOutput: which output of which earlier stage
};

/// One stage as the orchestrator sees it: nouns in, a verb, nouns out.
struct Task {
  std::string name;  ///< [a-z0-9_]+: "fit_global"
  std::string doc;   ///< one sentence
  std::string source;
  int version = 1;  ///< raise it whenever the same input and parameters give other bytes
  std::vector<Parameter> parameters;
  std::vector<TaskInput> inputs;
  std::vector<std::string> outputs;  ///< file names: "cloud.vdb"
  std::string summary;               ///< which output is a JSON object of figures for the user; may be empty
  std::function<void(TaskContext&)> run;  ///< empty where only the tables are linked
  /// "--views": runs only where `phiz fit` is given this flag or told to run until it; empty: always. No
  /// stage that always runs may need it.
  std::string option = {};
};

TaskInput scan_input();                                                    ///< "scan"
TaskInput template_mesh_input();                                           ///< "template.obj"
TaskInput template_annotations_input();                                    ///< "template.json"
TaskInput output_of(const std::string& stage, const std::string& output);  ///< named as the output

}  // namespace phiz
