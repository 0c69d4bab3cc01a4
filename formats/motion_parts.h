#pragma once

#include <string>

#include "formats/motion.h"

namespace phiz::motion_parts {

Motion parse_json(const std::string& text);
Motion parse_csv(const std::string& text);

/// Throws FormatError with the place where it is not finite or absurd.
float to_value(double value, const std::string& place);
bool is_name(const std::string& name);
std::string exact_text(float value);  ///< the shortest text that reads back exactly

}  // namespace phiz::motion_parts
