#pragma once

#include <string>

#include "orchestrator/session.h"
#include "store/result.h"

namespace phiz {

/// What "dev00/head.glb", "dev00/ingest/cloud.vdb" or the 64 digits of a digest name in the store.
/// Throws UsageError if the subject has no such output or several stages have one of that name.
OutputObject find_referenced_object(const Session& session, const Store& store, const std::string& reference);

}  // namespace phiz
