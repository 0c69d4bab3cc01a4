#pragma once

#include <string>

#include "formats/deformation.h"
#include "formats/image.h"

namespace phiz {

// The pieces of read_deformation and write_deformation.

std::string format_deformation_json(const Deformation& deformation);
/// Everything but images and windows. Throws FormatError with the key.
Deformation parse_deformation_json(const std::string& text);

/// All layers on the full grid.
FloatImage make_field_layers(const Deformation& deformation);
/// Puts the layers into the fields, cropped. Throws FormatError: layers missing or too many, size, template.
void take_field_layers(const FloatImage& image, Deformation& deformation);

}  // namespace phiz
