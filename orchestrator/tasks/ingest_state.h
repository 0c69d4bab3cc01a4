#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "stages/ingest/ingest.h"

namespace phiz {

/// Checkpoint of an ingest. Bytes of this machine's own layout: they are read by the same program or not at
/// all.
std::string encode_ingest_state(const IngestState& state);

/// Nothing if the bytes are no such state.
std::optional<IngestState> decode_ingest_state(std::string_view bytes);

}  // namespace phiz
