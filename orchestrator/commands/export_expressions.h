#pragma once

#include <optional>
#include <string>

#include "orchestrator/session.h"

namespace phiz {

struct ExpressionExport {
  std::string rig;
  std::optional<std::string> motion;
  int level = 2;
};

/// The .glb of a fitted head with a morph target for each of a rig's controls, and a motion of them.
std::string make_expression_file(const Session& session, const std::string& asset_bytes,
                                 const ExpressionExport& what);

/// The .glb of several levels, finest first, as MSFT_lod names them.
std::string make_lod_file(const std::string& asset_bytes, const std::string& levels);

}  // namespace phiz
