#pragma once

#include "stages/animate/living_surface.h"
