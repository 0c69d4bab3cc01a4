#pragma once

/// Adaptive meshes over the (u,v) square of heads, and over anything else: the parts in the order in which
/// they build on each other.
#include "stages/adapt/adaptive_mesh.h"        // refine, simplify, adapt
#include "stages/adapt/base_mesh.h"            // bases over (u,v)
#include "stages/adapt/compliance.h"           // bases for it
#include "stages/adapt/criteria.h"             // when to refine
#include "stages/adapt/face_points.h"          // what is known of the surface
#include "stages/adapt/importance.h"           // what counts more
#include "stages/adapt/multi_triangulation.h"  // the restricted hierarchy
#include "stages/adapt/posed_surface.h"        // surfaces that move
#include "stages/adapt/stellar_mesh.h"         // split and weld
