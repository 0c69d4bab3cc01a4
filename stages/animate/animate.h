#pragma once

#include "stages/animate/face_layout.h"
#include "stages/animate/living_surface.h"
#include "stages/animate/playback.h"
#include "stages/animate/pose_solver.h"
#include "stages/animate/skin.h"
