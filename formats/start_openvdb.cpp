#include "formats/start_openvdb.h"

#include <openvdb/openvdb.h>
#include <openvdb/util/logging.h>

namespace phiz {

void start_openvdb() {
  static const bool started = [] {
    openvdb::initialize();
    openvdb::logging::setLevel(openvdb::logging::Level::Fatal);
    return true;
  }();
  static_cast<void>(started);
}

}  // namespace phiz
