#pragma once

#include <filesystem>
#include <set>
#include <span>
#include <vector>

#include "store/file_system.h"

namespace phiz {

/// Puts several whole files in place so that a power cut leaves each of them either as it was or complete.
///
/// add() writes a temporary file in the target's own folder. publish() syncs all of them, renames them in the
/// order of add(), then syncs each folder once: the price of a batch is that of its slowest file, not the
/// sum. What was not published is removed by the destructor; what a killed process leaves is named ".tmp-…"
/// and is never read.
class DurableWriter {
 public:
  explicit DurableWriter(FileSystem& files) : files_(files) {}
  ~DurableWriter();
  DurableWriter(const DurableWriter&) = delete;
  DurableWriter& operator=(const DurableWriter&) = delete;

  /// The folder must exist (make_folder_for). An existing target is replaced by publish(); callers that may
  /// not replace look first. Throws StoreError.
  void add(const std::filesystem::path& target, std::span<const std::byte> bytes, FileSystem::Mode mode);

  /// Makes `folder` if it is missing (its parent must exist) and sees to it that publish() makes its name
  /// durable.
  void make_folder(const std::filesystem::path& folder);

  /// Throws StoreError. Targets renamed before the failure stay (each is whole); the others are not touched.
  void publish();

 private:
  struct Pending {
    std::filesystem::path temporary, target;
  };
  FileSystem& files_;
  std::vector<Pending> pending_;
  std::set<std::filesystem::path> folders_;
};

/// True for names that DurableWriter gives to files that are not finished.
bool is_temporary_name(const std::string& name);

/// A name no other process or thread uses: random per process, counted within it.
std::string make_unique_name();

}  // namespace phiz
