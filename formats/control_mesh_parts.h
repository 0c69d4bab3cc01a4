#pragma once

#include <string>

#include "formats/control_mesh.h"

// The two files of a control mesh; control_mesh.cpp puts them together and checks the whole.
namespace phiz::control_mesh_parts {

/// Fills positions, triangles and uv. Throws FormatError with the line.
ControlMesh parse_obj(const std::string& text);
std::string format_obj(const ControlMesh& mesh);

/// Throws FormatError with the key. Indices are not yet known to be in range.
Annotations parse_json(const std::string& text);
std::string format_json(const Annotations& annotations);

}  // namespace phiz::control_mesh_parts
