#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "store/digest.h"
#include "store/result.h"

namespace phiz {

/// What a subject's record remembers of a result, so that ten thousand finished subjects can be looked
/// through without parsing five files each. Never trusted over the result: Store::has compares it with the
/// result's file byte for byte (by its seal) and with the objects that are there. Always rebuildable from the
/// result.
struct ResultNote {
  Digest key;
  Digest seal;  ///< of the result's file: its digest, and so the file's name for "these very bytes"
  double seconds = 0;
  std::map<std::string, Digest> inputs;  ///< those that are digests
  std::map<std::string, OutputObject> outputs;
  bool operator==(const ResultNote&) const = default;
};

ResultNote make_note(const Result& result);

/// By stage. One entry a line, words separated by one space:
///   result <stage> <key> <seal> <seconds>
///   input <name> <digest>
///   output <name> <digest> <bytes>
/// Notes whose names hold a space, a quote, a backslash or a control character are left out.
std::string format_notes(const std::map<std::string, ResultNote>& notes);

/// Nothing at all if a line is not of that grammar: notes are only ever a shortcut.
std::map<std::string, ResultNote> parse_notes(std::string_view text);

}  // namespace phiz
