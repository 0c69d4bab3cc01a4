#pragma once

#include <string>
#include <vector>

#include "formats/control_mesh.h"
#include "stages/template/check.h"
#include "stages/template/layout.h"

namespace phiz::test {

/// The generic head and its layout as they lie in samples/generic_head.
const ControlMesh& generic_head();
std::string generic_layout_text();

/// The text read as a layout.
Layout to_layout(const std::string& text);

/// A small layout: the four corners, a mirror line with one more point, one closed curve beside it.
std::string small_layout_text();

/// What falls short, by name.
std::vector<std::string> list_short(const std::vector<HeadCheck>& checks);

/// What the checks measured under this name; "not measured" where there is no such check.
std::string find_value(const std::vector<HeadCheck>& checks, const std::string& what);

}  // namespace phiz::test
