#pragma once

#include <filesystem>

#include "formats/deformation.h"
#include "stages/deform/deform.h"
#include "tests/bench/areas.h"

namespace phiz::bench {

/// The designed muscles as a rig, made by the program, and the fitted subjects: what the figures of `fields`
/// are measured on.
struct FieldsWorld {
  const BenchWorld& bench;
  std::filesystem::path store, rig_path;  ///< rig_path without extension
  FitRun fits;
  Deformation rig;
};

FieldsWorld make_fields_world(const BenchWorld& bench);

/// A fitted subject's neutral surface.
NeutralSurface load_neutral(const FieldsWorld& world, const std::string& subject, const NeutralMaker& maker);

void measure_cascade_speed(const FieldsWorld& world);  ///< fields_cascade.cpp
void measure_exactness(const FieldsWorld& world);      ///< fields_cascade.cpp: neutral, left smile
void measure_retarget(const FieldsWorld& world);       ///< fields_retarget.cpp
void measure_track(const FieldsWorld& world);          ///< fields_track.cpp
void measure_learned_fields(const FieldsWorld& world);  ///< bench_fields_learned.cpp: images, learned, PCA

}  // namespace phiz::bench
