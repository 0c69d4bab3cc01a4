#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "store/digest.h"

namespace phiz {

/// The name of a result: SHA-256 over a text that lists everything the result depends on, and nothing else
/// (no path, time, host or thread count). The text is kept with the result, so that two keys can be compared
/// line by line.
///
/// Grammar, one entry a line, lengths in bytes so that no value can imitate another entry:
///   phiz-key 1 LF
///   ( tag SP name SP length SP value LF )*
/// tag is `stage`, `version`, `parameter` or `input`; tag and name are [a-z0-9_.]+ .
class KeyText {
 public:
  struct Entry {
    std::string tag, name, value;
    bool operator==(const Entry&) const = default;
  };

  /// Order of calls is order in the text: callers add parameters and inputs sorted by name.
  /// Throws StoreError kInvalidName if tag or name are not [a-z0-9_.]+.
  void add(std::string_view tag, std::string_view name, std::string_view value);

  const std::vector<Entry>& entries() const { return entries_; }
  std::string text() const;
  Digest key() const { return compute_digest(text()); }

 private:
  std::vector<Entry> entries_;
};

/// Nothing if the text is not of the grammar above.
std::optional<KeyText> parse_key_text(std::string_view text);

/// One entry that differs between two keys; an absent side is empty.
struct KeyDifference {
  std::string tag, name;
  std::optional<std::string> before, after;
};

/// In the order of `after`, then what only `before` has. Empty means: the same key.
std::vector<KeyDifference> compare_keys(const KeyText& before, const KeyText& after);

}  // namespace phiz
