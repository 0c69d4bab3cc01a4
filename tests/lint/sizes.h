#pragma once

#include <string>
#include <vector>

#include "tests/lint/source_tree.h"

namespace phiz::lint {

struct SizeLimits {
  int header_lines = 150;
  int source_lines = 400;
  int test_lines = 800;  ///< of a source below tests/; the length of its functions is free
  int function_lines = 60;
};

/// Files and functions above the limits, as "path:line: what". Functions are found by our own layout
/// (.clang-format): a definition begins at column 0 and ends with a '}' there, or, inside a class of a .cpp
/// file, at two spaces. Also: headers without `#pragma once`.
std::vector<std::string> find_size_violations(const std::vector<SourceFile>& files,
                                              const SizeLimits& limits = {});

}  // namespace phiz::lint
