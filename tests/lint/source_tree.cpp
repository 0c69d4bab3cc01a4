#include "tests/lint/source_tree.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace phiz::lint {

namespace fs = std::filesystem;

std::vector<SourceFile> read_source_tree(const std::vector<std::string>& folders,
                                         const std::vector<std::string>& endings) {
  std::vector<SourceFile> files;
  const fs::path root = PHIZ_SOURCE_FOLDER;
  for (const std::string& folder : folders) {
    if (!fs::is_directory(root / folder)) continue;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string path = entry.path().lexically_relative(root).generic_string();
      const bool is_wanted = std::any_of(endings.begin(), endings.end(),
                                         [&](const std::string& ending) { return path.ends_with(ending); });
      if (!entry.is_regular_file() || !is_wanted) continue;
      std::ostringstream text;
      text << std::ifstream(entry.path(), std::ios::binary).rdbuf();
      files.push_back(make_source(path, text.str()));
    }
  }
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
  return files;
}

SourceFile make_source(const std::string& path, const std::string& text) {
  SourceFile file{path, {}};
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) file.lines.push_back(line);
  return file;
}

}  // namespace phiz::lint
