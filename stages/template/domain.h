#pragma once

#include "formats/control_mesh.h"
#include "stages/template/triangulate.h"

namespace phiz {

struct DomainOptions {
  double face_share = 0.59;  ///< of the square, sought for the region `face`
  double hidden_size = 0.5;  ///< length of a mm in the pocket of the mouth and the nostrils, against the face
  double ear_size = 0.75;    ///< and in the ears
  double start_size = 0.35;  ///< and elsewhere, to begin with: adjusted until the face has its share
  int rounds = 8;
};

/// The (u,v) that a head is published with: relaxes the map of the whole mesh (from the half's, which is
/// one-to-one) until its region `face` has its share of the square and distortion is spread. Symmetric, on
/// six decimals, and one-to-one still. Throws NumericalFailure if rounding turns a triangle over.
void relax_domain(const HalfMesh& half, ControlMesh& mesh, const DomainOptions& options = {});

}  // namespace phiz
