#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "stages/fit/fit.h"

namespace phiz {

/// The bytes of a checkpoint of the global fit: exact doubles, so that a resumed fit ends in the same bytes.
/// For this machine and version only.
std::string encode_fit_state(const GlobalFitState& state);

/// Nothing if the bytes are not a state of a mesh with `vertex_count` vertices.
std::optional<GlobalFitState> decode_fit_state(std::string_view bytes, std::size_t vertex_count);

}  // namespace phiz
