#include "tests/lint/sizes.h"

#include <algorithm>

namespace phiz::lint {
namespace {

/// The last line of a function's head, as our layout writes it; a table of data ends otherwise.
bool opens_function(const std::string& line) {
  for (const char* end : {") {", " const {", " override {", " noexcept {", "} {"}) {
    if (line.ends_with(end)) return true;
  }
  return false;
}

bool is_scope(const std::string& line) {
  for (const char* word :
       {"namespace", "class ", "struct ", "union ", "enum ", "extern \"C\" {", "template <class"}) {
    if (line.find(word) == 0) return true;
  }
  return false;
}

bool is_class(const std::string& line) {
  return line.starts_with("class ") || line.starts_with("struct ");
}

bool begins_at(const std::string& line, std::size_t indent) {
  return line.size() > indent && line.find_first_not_of(' ') == indent && line[indent] != '}' &&
         line[indent] != '#' && line[indent] != '/' && !line.ends_with(":");
}

/// Functions at one indentation: from the line where a definition begins to the '}' at the same column. At
/// two spaces only within classes; elsewhere that is the inside of functions.
void find_long_functions(const SourceFile& file, std::size_t indent, int limit,
                         std::vector<std::string>& violations) {
  const std::string end = std::string(indent, ' ') + "}";
  bool in_class = false;
  for (std::size_t begin = 0; begin < file.lines.size(); ++begin) {
    if (begins_at(file.lines[begin], 0)) in_class = is_class(file.lines[begin]);
    if (indent > 0 && !in_class) continue;
    if (!begins_at(file.lines[begin], indent) || is_scope(file.lines[begin].substr(indent))) continue;
    std::size_t open = begin;  // a definition's head may take several lines
    while (open < file.lines.size() && !file.lines[open].ends_with("{") && !file.lines[open].ends_with(";") &&
           !file.lines[open].ends_with("}") && !file.lines[open].empty()) {
      ++open;
    }
    if (open == file.lines.size() || !opens_function(file.lines[open])) continue;
    std::size_t close = open + 1;
    while (close < file.lines.size() && !file.lines[close].starts_with(end)) ++close;
    const int length = static_cast<int>(close - begin) + 1;
    if (length > limit) {
      violations.push_back(file.path + ":" + std::to_string(begin + 1) + ": a function of " +
                           std::to_string(length) + " lines, at most " + std::to_string(limit));
    }
    begin = close;
  }
}

void check_length(const SourceFile& file, int limit, const char* kind, std::vector<std::string>& violations) {
  const int length = static_cast<int>(file.lines.size());
  if (length <= limit) return;
  violations.push_back(file.path + ":" + std::to_string(length) + ": a " + kind + " of " +
                       std::to_string(length) + " lines, at most " + std::to_string(limit));
}

}  // namespace

std::vector<std::string> find_size_violations(const std::vector<SourceFile>& files,
                                              const SizeLimits& limits) {
  std::vector<std::string> violations;
  for (const SourceFile& file : files) {
    const bool is_test = file.path.starts_with("tests/");
    if (file.path.ends_with(".h")) {
      check_length(file, limits.header_lines, "header", violations);
      if (std::count(file.lines.begin(), file.lines.end(), "#pragma once") != 1) {
        violations.push_back(file.path + ":1: no #pragma once");
      }
    } else {
      check_length(file, is_test ? limits.test_lines : limits.source_lines, "source", violations);
      if (is_test) continue;
      find_long_functions(file, 0, limits.function_lines, violations);
      find_long_functions(file, 2, limits.function_lines, violations);
    }
  }
  return violations;
}

}  // namespace phiz::lint
