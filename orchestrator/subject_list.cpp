#include "orchestrator/subject_list.h"

#include <algorithm>

#include "orchestrator/error.h"

namespace phiz {
namespace {

class Reader {
 public:
  Reader(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  /// The next row that says something; empty at the end.
  std::vector<std::string> read_row() {
    while (!text_.empty()) {
      row_line_ = line_;
      const bool is_comment = text_.front() == '#';
      std::vector<std::string> fields = is_comment ? skip_line() : read_fields();
      const bool is_blank = fields.empty() || (fields.size() == 1 && fields[0].empty());
      if (!is_blank) return fields;
    }
    return {};
  }

  int row_line() const { return row_line_; }

  [[noreturn]] void fail(const std::string& what) const {
    throw UsageError(file_ + ": " + what + " (line " + std::to_string(row_line_) + ")",
                     "a list has a header line, for example: subject,scan");
  }

 private:
  std::vector<std::string> skip_line() {
    const std::size_t end = text_.find('\n');
    text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
    ++line_;
    return {};
  }

  std::vector<std::string> read_fields() {
    std::vector<std::string> fields;
    for (;;) {
      fields.push_back(!text_.empty() && text_.front() == '"' ? read_quoted() : read_plain());
      if (text_.empty()) return fields;
      const char end = text_.front();
      text_.remove_prefix(1);
      if (end == '\n') {
        ++line_;
        return fields;
      }
    }
  }

  std::string read_plain() {
    const std::size_t end = std::min(text_.find_first_of(",\n"), text_.size());
    std::string_view field = text_.substr(0, end);
    text_.remove_prefix(end);
    if (field.ends_with('\r')) field.remove_suffix(1);
    while (field.starts_with(' ')) field.remove_prefix(1);
    while (field.ends_with(' ')) field.remove_suffix(1);
    return std::string(field);
  }

  std::string read_quoted() {
    std::string field;
    text_.remove_prefix(1);
    for (;;) {
      if (text_.empty()) fail("a quoted field has no end");
      const char c = text_.front();
      text_.remove_prefix(1);
      if (c == '\n') ++line_;
      if (c != '"') {
        field += c;
      } else if (text_.starts_with('"')) {
        field += '"';
        text_.remove_prefix(1);
      } else {
        break;
      }
    }
    if (text_.starts_with('\r')) text_.remove_prefix(1);
    if (!text_.empty() && text_.front() != ',' && text_.front() != '\n') fail("text after a quoted field");
    return field;
  }

  std::string_view text_;
  const std::string& file_;
  int line_ = 1, row_line_ = 1;
};

}  // namespace

std::vector<SubjectListRow> parse_subject_list(std::string_view text, const std::string& file) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  Reader reader(text, file);
  const std::vector<std::string> header = reader.read_row();
  if (std::count(header.begin(), header.end(), "scan") != 1) reader.fail("no column 'scan'");
  std::vector<SubjectListRow> rows;
  for (std::vector<std::string> fields = reader.read_row(); !fields.empty(); fields = reader.read_row()) {
    if (fields.size() != header.size()) {
      reader.fail(std::to_string(fields.size()) + " fields under " + std::to_string(header.size()) +
                  " columns");
    }
    SubjectListRow row{reader.row_line(), {}};
    for (std::size_t i = 0; i < fields.size(); ++i) row.fields[header[i]] = std::move(fields[i]);
    if (row.fields["scan"].empty()) reader.fail("no scan named");
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace phiz
