#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "orchestrator/command_line.h"
#include "orchestrator/environment.h"
#include "orchestrator/inputs.h"
#include "orchestrator/report.h"
#include "store/store.h"

namespace phiz {

/// What a command works with: its environment, the global options, the store.
class Session {
 public:
  Session(const Environment& environment, GlobalOptions globals);

  const Environment& environment() const { return environment_; }
  const GlobalOptions& globals() const { return globals_; }
  const Pipeline& pipeline() const { return environment_.pipeline; }
  FileSystem& files() const { return environment_.files; }
  Reporter& reporter() { return *reporter_; }

  std::filesystem::path store_path() const;  ///< --store, else $PHIZ_STORE, else ./phiz-store
  Store open_store() const;                  ///< throws StoreError kNoStore
  Store open_or_create_store() const;

  /// The generic head: `path` if given, else $PHIZ_TEMPLATE, else the one that came with the program.
  TemplateFiles load_head(const std::optional<std::string>& path) const;

  /// A line of the result on stdout; nothing with --json.
  void print(const std::string& line) const;
  /// An object of the result with --json; nothing without.
  void print_json(const nlohmann::ordered_json& object) const;

  /// The subject's record. Throws UsageError if the store has none of that name.
  SubjectRecord get_subject(const Store& store, const std::string& name) const;

 private:
  const Environment& environment_;
  GlobalOptions globals_;
  std::unique_ptr<Reporter> reporter_;
};

}  // namespace phiz
