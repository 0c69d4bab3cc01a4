#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace phiz {

/// One row of `phiz fit --list FILE.csv`.
struct SubjectListRow {
  int line = 0;                               ///< in the file, from 1
  std::map<std::string, std::string> fields;  ///< column -> text
};

/// Comma-separated text with a header line; fields may be quoted ("a, b", "" for a quote), lines end in LF or
/// CRLF, empty lines and lines that begin with # are skipped. Throws UsageError with file and line.
std::vector<SubjectListRow> parse_subject_list(std::string_view text, const std::string& file);

}  // namespace phiz
