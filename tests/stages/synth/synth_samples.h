#pragma once

#include "stages/synth/synth.h"

namespace phiz::test {

ControlMesh read_generic_head();

/// The generic head at a level, made once a run.
const SubjectBase& generic_base(int level);

/// A target of plain skin.
ScanTarget make_plain_target(TriangleMesh mesh);

/// No noise, nothing lost but by geometry, no outliers, no registration error.
ScanOptions exact_scan(int points);

}  // namespace phiz::test
