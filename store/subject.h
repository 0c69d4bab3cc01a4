#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "store/digest.h"
#include "store/result_note.h"

namespace phiz {

/// What the store knows of one subject: where its scan came from, which result of each stage is current, and
/// which were current before.
struct SubjectRecord {
  struct Past {
    std::string stage;
    Digest key;
    bool operator==(const Past&) const = default;
  };

  std::string name;
  std::string scan_path;  ///< absolute, as it was when last fitted
  Digest scan_digest;
  std::uint64_t scan_bytes = 0;
  std::map<std::string, Digest> results;  ///< stage -> key of its current result
  std::vector<Past> history;              ///< former results, oldest first, the last 64
  /// FileSystem::find_stamp of the scan when it was hashed; empty: hash it again.
  std::string scan_stamp = {};
  std::map<std::string, ResultNote> notes = {};  ///< stage -> note of its current result, where there is one

  /// Makes `key` current; what was current goes to the history.
  void set_current(const std::string& stage, const Digest& key);

  /// Likewise, and remembers the note.
  void set_current(const std::string& stage, ResultNote note);

  /// The note of the stage's current result, if there is one.
  const ResultNote* find_note(const std::string& stage) const;

  bool operator==(const SubjectRecord&) const = default;
};

/// File `subjects/<name>.json`, sealed.
std::string format_subject(const SubjectRecord& record);
SubjectRecord parse_subject(std::string_view text, const std::string& what);  ///< throws StoreError kDamaged

/// 1-100 of A-Z a-z 0-9 . _ - , first one a letter, digit or _ . Throws StoreError kInvalidName otherwise.
void validate_subject_name(const std::string& name);

/// A valid name for a file's stem. A stem that is valid is kept; otherwise other bytes become '_', the length
/// is cut and a short digest of the stem is added, so that different stems stay different subjects.
std::string make_subject_name(std::string_view stem);

}  // namespace phiz
