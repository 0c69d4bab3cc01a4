#pragma once

namespace phiz {

/// A position with a fourth number that is always 0: one load.
struct alignas(16) Point4 {
  float x = 0, y = 0, z = 0, w = 0;
};

}  // namespace phiz
