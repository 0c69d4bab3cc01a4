#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "store/digest.h"
#include "store/key.h"

namespace phiz {

struct OutputObject {
  Digest digest;
  std::uint64_t size_bytes = 0;
  bool operator==(const OutputObject&) const = default;
};

/// How a result came about. Kept apart from what it is: no part of any key or digest.
struct RunRecord {
  double seconds = 0;
  std::uint64_t peak_memory_bytes = 0;
  std::string host, tool_version;
  std::string reason;  ///< why it was computed, in words
};

/// What one stage made of its inputs. The key text says from what; the outputs are objects.
struct Result {
  KeyText key_text;
  std::map<std::string, OutputObject> outputs;  ///< "cloud.vdb" -> object
  RunRecord run;
  Digest seal;  ///< of its file, where it was read from one or committed

  Digest key() const { return key_text.key(); }
  std::string stage() const;  ///< empty if the key text names none
};

/// File `results/<key>.json`, sealed: stage, version, parameters, inputs (from the key text, for people),
/// key_text, outputs (name -> digest, bytes) and, apart, run.
std::string format_result(const Result& result);

/// Throws StoreError kDamaged. `what` names the file in the message.
Result parse_result(std::string_view text, const std::string& what);

}  // namespace phiz
