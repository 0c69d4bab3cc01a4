#pragma once

#include <span>

#include "formats/control_mesh.h"
#include "formats/muscle_file.h"

namespace phiz {

struct MuscleOptions {
  int side = 512;  ///< nodes of the (u,v) grid a side, 16 .. 4096
};

/// Draws designed muscles into the generic head's (u,v) square and chains them: neutral, skin, jaw, what
/// follows the jaw. Controls get aliases: PascalCase and, for Left and Right, `_L` and `_R`. Throws
/// InvalidInput that names muscle and landmark, region or parameter. 1 s for 50 muscles at 512 x 512.
/// Source: Goldenstein, Vogler, Velho: muscles as vector fields over the (u,v) square.
Deformation build_muscles(const ControlMesh& generic_head, std::span<const MuscleFile> muscles,
                          const RigFile& rig, const MuscleOptions& options = {});

}  // namespace phiz
