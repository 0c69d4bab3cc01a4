#pragma once

#include <string>
#include <vector>

namespace phiz::lint {

/// One text file of the tree, by its path from the root.
struct SourceFile {
  std::string path;
  std::vector<std::string> lines;
};

/// Every file below the given folders of the source tree whose name ends in one of `endings`, sorted by path.
std::vector<SourceFile> read_source_tree(const std::vector<std::string>& folders,
                                         const std::vector<std::string>& endings);

/// Text to lines, for planted examples.
SourceFile make_source(const std::string& path, const std::string& text);

}  // namespace phiz::lint
