#pragma once

namespace phiz {

/// OpenVDB's types registered and its log silent: it writes to stdout, which is for results. Before any use
/// of the library; cheap when called again. Thread-safe.
void start_openvdb();

}  // namespace phiz
