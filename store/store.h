#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "store/durable_writer.h"
#include "store/file_system.h"
#include "store/layout.h"
#include "store/result.h"
#include "store/subject.h"

namespace phiz {

/// What Store::commit makes durable in one go. A subject's record gets the note of the result.
struct CommitRequest {
  Result result;                                 ///< key_text and run; outputs are filled in by commit
  std::map<std::string, std::string> outputs;    ///< name -> bytes
  std::vector<std::string_view> inputs_to_keep;  ///< bytes that become objects too (the generic head's files)
  std::optional<SubjectRecord> subject;          ///< saved in the same step
};

struct CommitOutcome {
  Result result;
  bool differed = false;  ///< a finished result of this key was there with other outputs; it was kept
};

/// The names that were in a store at one moment: to look at ten thousand subjects at the price of a few
/// hundred folders. Says nothing of lengths.
struct StoreNames {
  std::vector<Digest> objects, results;  ///< sorted
  bool has(const ResultNote& note) const;
};

/// Objects by content, results by key, records of subjects, in one folder. See README.md for what is promised
/// after a kill, a power cut, a full disk. Safe for many threads and many processes. All calls throw
/// StoreError.
class Store {
 public:
  /// Throws kNoStore if `root` is no store, kUnknownVersion if it is one of another format version.
  static Store open(FileSystem& files, const std::filesystem::path& root);

  /// Makes the store if `root` is missing or an empty folder. kNoStore if it is a folder of other things.
  static Store open_or_create(FileSystem& files, const std::filesystem::path& root);

  /// Writes the marker of a store anew if its bytes are damaged; the damaged one goes to `damaged/`. True if
  /// it did. Throws kNoStore if there is none.
  static bool repair_marker(FileSystem& files, const std::filesystem::path& root);

  FileSystem& files() const { return *files_; }
  const StoreLayout& layout() const { return layout_; }

  // Objects -------------------------------------------------------------------------------------------------
  std::optional<std::uint64_t> find_object_size(const Digest& digest) const;

  /// Every byte checked against the digest. A damaged object is set aside and kDamaged thrown; kMissing if
  /// none.
  std::string read_object(const Digest& digest) const;

  /// Adds an object to a batch. Existing content is compared and nothing written; if the file there is
  /// damaged it is set aside and replaced. O(bytes).
  OutputObject put_object(DurableWriter& writer, std::string_view bytes) const;

  std::vector<Digest> list_objects() const;  ///< sorted
  StoreNames list_names() const { return {list_objects(), list_results()}; }

  // Results -------------------------------------------------------------------------------------------------
  /// The result if its file is there. A damaged file is set aside and counts as not there.
  std::optional<Result> find_result(const Digest& key) const;

  /// The result if it is done: every output object exists with its length.
  std::optional<Result> find_done_result(const Digest& key) const;

  /// True if what the note says is there: the result's file, and every output object with its length.
  enum class Care {
    kLook,   ///< looks at names and lengths only
    kCheck,  ///< reads the result's file too: every byte must be as noted
  };
  bool has(const ResultNote& note, Care care) const;

  /// Names of outputs whose object is missing or has another length.
  std::vector<std::string> list_missing_outputs(const Result& result) const;

  /// Objects first, then result and subject, each step durable before the next. A finished result of the same
  /// key is kept, never replaced.
  CommitOutcome commit(CommitRequest request) const;

  /// A result whose outputs are there already, as it is. A finished result of the same key is kept.
  void put_result(const Result& result) const;

  std::vector<Digest> list_results() const;  ///< sorted keys

  /// Results that no subject names but that must stay: garbage is collected around them.
  void pin(const Digest& key) const;
  bool unpin(const Digest& key) const;    ///< true if it was pinned
  std::vector<Digest> list_pins() const;  ///< sorted

  // Subjects ------------------------------------------------------------------------------------------------
  std::optional<SubjectRecord> find_subject(const std::string& name) const;  ///< nothing if none; kDamaged
  void save_subject(const SubjectRecord& record) const;  ///< durable; no write if unchanged
  std::vector<std::string> list_subjects() const;        ///< sorted

  /// Moves a damaged file out of the way into `damaged/`. Returns its new place.
  std::filesystem::path set_aside(const std::filesystem::path& file) const;

 private:
  Store(FileSystem& files, std::filesystem::path root) : files_(&files), layout_{std::move(root)} {}
  void put_back_removed(const CommitRequest& request, const Result& result) const;
  void add_subject(DurableWriter& writer, const SubjectRecord& record) const;

  FileSystem* files_;
  StoreLayout layout_;
};

}  // namespace phiz
