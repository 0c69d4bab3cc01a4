#pragma once

#include "orchestrator/command.h"

namespace phiz {

// The children of `phiz fields` that have files of their own.
Command make_fields_learn_command();
Command make_fields_pca_command();
Command make_fields_shape_command();
Command make_fields_show_command();

}  // namespace phiz
