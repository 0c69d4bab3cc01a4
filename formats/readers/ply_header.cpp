#include "formats/readers/ply_header.h"

#include <charconv>
#include <string_view>

#include "formats/readers/fail.h"
#include "formats/readers/text_lines.h"

namespace phiz::readers {
namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

PlyType parse_type(std::string_view word, std::uint64_t line) {
  static constexpr std::pair<std::string_view, PlyType> kNames[] = {
      {"char", PlyType::i8},    {"int8", PlyType::i8},     {"uchar", PlyType::u8},
      {"uint8", PlyType::u8},   {"short", PlyType::i16},   {"int16", PlyType::i16},
      {"ushort", PlyType::u16}, {"uint16", PlyType::u16},  {"int", PlyType::i32},
      {"int32", PlyType::i32},  {"uint", PlyType::u32},    {"uint32", PlyType::u32},
      {"float", PlyType::f32},  {"float32", PlyType::f32}, {"double", PlyType::f64},
      {"float64", PlyType::f64}};
  for (const auto& [name, type] : kNames)
    if (equals_lower(word, name)) return type;
  if (word.empty()) fail_at_line("a property has no type", line, kHintCut);
  fail_at_line(quoted(word) + " is no type of a PLY property", line,
               "char uchar short ushort int uint float double");
}

std::string parse_name(Fields& fields) {
  const std::string_view word = fields.next_word();
  if (word.empty()) fail_at_line("a name is missing", fields.line_number(), kHintCut);
  return lower(word);
}

PlyEncoding parse_encoding(Fields& fields) {
  const std::string_view word = fields.next_word();
  if (equals_lower(word, "ascii")) return PlyEncoding::ascii;
  if (equals_lower(word, "binary_little_endian")) return PlyEncoding::little_endian;
  if (equals_lower(word, "binary_big_endian")) return PlyEncoding::big_endian;
  fail_at_line(quoted(word) + " is no PLY format", fields.line_number(),
               "ascii, binary_little_endian or binary_big_endian");
}

PlyElement parse_element(Fields& fields) {
  PlyElement element;
  element.name = parse_name(fields);
  const std::string_view word = fields.next_word();
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), element.count);
  if (word.empty() || error != std::errc() || stop != word.data() + word.size())
    fail_at_line(quoted(word) + " is not a count of '" + element.name + "'", fields.line_number(),
                 kHintDamaged);
  return element;
}

PlyProperty parse_property(Fields& fields) {
  PlyProperty property;
  std::string_view word = fields.next_word();
  property.is_list = equals_lower(word, "list");
  if (property.is_list) {
    property.count_type = parse_type(fields.next_word(), fields.line_number());
    word = fields.next_word();
  }
  property.type = parse_type(word, fields.line_number());
  property.name = parse_name(fields);
  return property;
}

/// The lines of the header, one after the other; knows the byte behind the last.
class HeaderLines {
 public:
  explicit HeaderLines(std::span<const std::byte> bytes)
      : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {
    const std::size_t first_end = text_.find_first_of("\r\n");
    const bool ends_in_cr = first_end != std::string_view::npos && text_[first_end] == '\r';
    if (ends_in_cr && text_.substr(first_end + 1, 1) != "\n") terminator_ = '\r';
  }

  std::string_view next() {
    const std::size_t stop = text_.find(terminator_, at_);
    ++number_;
    if (stop == std::string_view::npos) fail_at_line("the header has no end_header", number_, kHintCut);
    std::string_view line = text_.substr(at_, stop - at_);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    at_ = stop + 1;
    return line;
  }
  std::size_t byte() const { return at_; }
  std::uint64_t number() const { return number_; }

 private:
  std::string_view text_;
  char terminator_ = '\n';
  std::size_t at_ = 0;
  std::uint64_t number_ = 0;
};

}  // namespace

std::size_t size_of(PlyType type) {
  static constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<int>(type)];
}

bool PlyElement::has_lists() const {
  for (const PlyProperty& property : properties)
    if (property.is_list) return true;
  return false;
}

std::size_t PlyElement::least_row_bytes(PlyEncoding encoding) const {
  if (encoding == PlyEncoding::ascii) return 2 * properties.size();  // a digit and a blank
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties)
    bytes += size_of(property.is_list ? property.count_type : property.type);
  return bytes;
}

int PlyElement::find_property(const std::string& wanted) const {
  for (std::size_t i = 0; i < properties.size(); ++i)
    if (properties[i].name == wanted) return static_cast<int>(i);
  return -1;
}

PlyHeader read_ply_header(std::span<const std::byte> bytes) {
  HeaderLines lines(bytes);
  if (lines.next() != "ply")
    fail_at_byte("does not begin with 'ply'", 0, "is it another format under this name?");
  PlyHeader header;
  bool has_format = false;
  while (true) {
    const std::string_view line = lines.next();
    Fields fields(line, lines.number());
    const std::string_view keyword = fields.next_word();
    if (keyword == "end_header") break;
    if (keyword == "format") {
      header.encoding = parse_encoding(fields);
      has_format = true;
    } else if (keyword == "element") {
      header.elements.push_back(parse_element(fields));
    } else if (keyword == "property") {
      if (header.elements.empty())
        fail_at_line("a property comes before any element", lines.number(), kHintDamaged);
      header.elements.back().properties.push_back(parse_property(fields));
    } else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
      fail_at_line(quoted(keyword) + " does not belong in a PLY header", lines.number(), kHintDamaged);
    }
  }
  if (!has_format) fail_at_line("the header has no format line", lines.number(), kHintDamaged);
  header.body_byte = lines.byte();
  header.body_line = lines.number() + 1;
  return header;
}

}  // namespace phiz::readers
