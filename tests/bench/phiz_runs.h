#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/e2e/program.h"

namespace phiz::bench {

/// One stage of one subject in a run of `phiz fit`.
struct StageRun {
  bool is_computed = false;  ///< false: kept from before
  double seconds = 0;
  std::map<std::string, std::string> digests;  ///< output -> SHA-256
  double first_fraction = 0;                   ///< progress it began with: above 0 after a checkpoint
};

struct SubjectRun {
  bool is_done = false;
  int code = 0;       ///< why it failed
  std::string error;  ///< likewise
  std::map<std::string, StageRun> stages;

  /// stage/output -> digest of everything; what two equal runs agree on.
  std::map<std::string, std::string> digests() const;
};

struct FitRun {
  test::ProgramRun program;
  std::map<std::string, SubjectRun> subjects;
};

struct FitOptions {
  std::filesystem::path store;
  int threads = 0;  ///< 0: phiz decides
  std::vector<std::string> arguments;
  std::optional<double> kill_after_s;
};

/// `phiz fit SCANS... --json` and what it reported. A killed run has the stages that it told of.
FitRun run_fit(const std::vector<std::filesystem::path>& scans, const FitOptions& options);

/// Any command, with --store.
test::ProgramRun run_phiz(const std::filesystem::path& store, std::vector<std::string> arguments);

/// Bytes of an object. Throws std::runtime_error if it is not there.
std::string read_object(const std::filesystem::path& store, const std::string& digest);

/// A folder for stores and scans, removed at the end of its scope.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace phiz::bench
