#pragma once

namespace phiz {

inline constexpr const char* kVersion = PHIZ_VERSION;

}  // namespace phiz
