// The Polygon File Format (Turk 1994): a text header that lists elements with their properties, then their
// rows.
#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/readers/byte_order.h"
#include "formats/readers/cloud_builder.h"
#include "formats/readers/fail.h"
#include "formats/readers/ply_header.h"
#include "formats/readers/readers.h"
#include "formats/readers/text_lines.h"

namespace phiz::readers {
namespace {

/// One row of an element: a number for each scalar property, and the numbers of one list.
struct Row {
  std::vector<double> scalars;  ///< by position of the property
  int list_idx = -1;            ///< which list is wanted; -1: none
  std::vector<double> list;
};

class AsciiRows {
 public:
  AsciiRows(std::span<const std::byte> bytes, const PlyHeader& header)
      : lines_(bytes.subspan(header.body_byte), header.body_line) {}

  std::size_t bytes_left() const { return lines_.bytes_left() + 1; }  // the last line may lack its end

  void next(const PlyElement& element, Row& row) {
    std::string_view line;
    if (!lines_.next_filled(line)) fail("a row of '" + element.name + "' is missing", kHintCut);
    Fields fields(line, lines_.number());
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      double value = 0.0;
      if (!fields.next_number(value)) fail("the row has no '" + element.properties[i].name + "'", kHintCut);
      if (element.properties[i].is_list)
        read_list(fields, value, static_cast<int>(i) == row.list_idx ? &row.list : nullptr);
      else
        row.scalars[i] = value;
    }
    if (!fields.at_end()) fail("the row has more numbers than the header says", kHintDamaged);
  }

  [[noreturn]] void fail(const std::string& fault, const std::string& hint) const {
    fail_at_line(fault, lines_.number(), hint);
  }

 private:
  void read_list(Fields& fields, double count, std::vector<double>* list) {
    if (!(count >= 0.0 && count <= 4294967295.0) || count != std::floor(count))
      fail("the length of a list is not a whole number", kHintDamaged);
    if (list) list->clear();
    double value = 0.0;
    for (double i = 0; i < count; ++i) {
      if (!fields.next_number(value)) fail("the list is shorter than it says", kHintCut);
      if (list) list->push_back(value);
    }
  }

  TextLines lines_;
};

template <bool kSwap>
class BinaryRows {
 public:
  BinaryRows(std::span<const std::byte> bytes, const PlyHeader& header)
      : bytes_(bytes), at_(header.body_byte) {}

  std::size_t bytes_left() const { return bytes_.size() - at_; }

  void next(const PlyElement& element, Row& row) {
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      if (property.is_list)
        read_list(property, static_cast<int>(i) == row.list_idx ? &row.list : nullptr);
      else
        row.scalars[i] = number(property.type);
    }
  }

  [[noreturn]] void fail(const std::string& fault, const std::string& hint) const {
    fail_at_byte(fault, at_, hint);
  }

 private:
  void read_list(const PlyProperty& property, std::vector<double>* list) {
    const double count = number(property.count_type);
    if (!(count >= 0.0) || count != std::floor(count))
      fail("the length of a list is not a whole number", kHintDamaged);
    if (count * static_cast<double>(size_of(property.type)) > static_cast<double>(bytes_left()))
      fail("the list is longer than the file", kHintCut);
    if (!list) {
      at_ += static_cast<std::size_t>(count) * size_of(property.type);
      return;
    }
    list->resize(static_cast<std::size_t>(count));
    for (double& value : *list) value = number(property.type);
  }

  double number(PlyType type) {
    const std::size_t size = size_of(type);
    if (bytes_left() < size) fail("the file ends within a row", kHintCut);
    const std::byte* const at = bytes_.data() + at_;
    at_ += size;
    switch (type) {
      case PlyType::i8:
        return load<std::int8_t>(at);
      case PlyType::u8:
        return load<std::uint8_t>(at);
      case PlyType::i16:
        return load<std::int16_t, kSwap>(at);
      case PlyType::u16:
        return load<std::uint16_t, kSwap>(at);
      case PlyType::i32:
        return load<std::int32_t, kSwap>(at);
      case PlyType::u32:
        return load<std::uint32_t, kSwap>(at);
      case PlyType::f32:
        return static_cast<double>(load<float, kSwap>(at));
      case PlyType::f64:
        break;
    }
    return load<double, kSwap>(at);
  }

  std::span<const std::byte> bytes_;
  std::size_t at_;
};

/// Where the attributes of a vertex stand among its properties.
struct VertexColumns {
  std::array<int, 3> position{}, normal{}, colour{};
  int confidence = -1, quality = -1;
  bool has_normal = false, has_colour = false, has_byte_colour = false;
  ColourRange colour_range = ColourRange::numbers;
};

bool find_three(const PlyElement& element, const std::array<const char*, 3>& names,
                std::array<int, 3>& columns) {
  for (int i = 0; i < 3; ++i) {
    columns[i] = element.find_property(names[i]);
    if (columns[i] < 0 || element.properties[columns[i]].is_list) return false;
  }
  return true;
}

VertexColumns find_columns(const PlyElement& element) {
  VertexColumns columns;
  if (!find_three(element, {"x", "y", "z"}, columns.position))
    throw FormatError("the vertices have no x, y and z (header)", "export with positions");
  columns.has_normal = find_three(element, {"nx", "ny", "nz"}, columns.normal) ||
                       find_three(element, {"normal_x", "normal_y", "normal_z"}, columns.normal);
  columns.has_colour = find_three(element, {"red", "green", "blue"}, columns.colour) ||
                       find_three(element, {"r", "g", "b"}, columns.colour) ||
                       find_three(element, {"diffuse_red", "diffuse_green", "diffuse_blue"}, columns.colour);
  if (columns.has_colour) {
    const PlyType type = element.properties[columns.colour[0]].type;
    columns.has_byte_colour = true;
    for (const int i : columns.colour) columns.has_byte_colour &= element.properties[i].type == PlyType::u8;
    const bool is_real = type == PlyType::f32 || type == PlyType::f64;
    columns.colour_range = is_real ? ColourRange::numbers : ColourRange::integers;
  }
  const auto find_scalar = [&](const char* name) {
    const int i = element.find_property(name);
    return i >= 0 && !element.properties[i].is_list ? i : -1;
  };
  columns.confidence = find_scalar("confidence");
  if (columns.confidence < 0) columns.quality = find_scalar("quality");
  return columns;
}

/// In ascii even a `uchar` may hold any number.
std::uint8_t clamp_to_byte(double value) {
  return value > 0.0 ? static_cast<std::uint8_t>(std::min(value, 255.0)) : std::uint8_t{0};
}

template <typename Rows>
class PlyBody {
 public:
  PlyBody(std::span<const std::byte> bytes, const PlyHeader& header, const ScanLimits& limits)
      : header_(header), limits_(limits), rows_(bytes, header) {}

  ScanFile read() {
    for (const PlyElement& element : header_.elements) {
      if (!is_vertex(element)) continue;
      CloudBuilder::check_count(element.count, limits_);
      if (std::exchange(vertex_count_, element.count) > 0)
        throw FormatError("two elements are called 'vertex' (header)", "export again");
    }
    ColourRange colour_range = ColourRange::numbers;
    for (const PlyElement& element : header_.elements) {
      check_size(element);
      if (is_vertex(element))
        colour_range = read_vertices(element);
      else if (element.name == "face")
        read_faces(element);
      else
        skip(element);
    }
    return builder_.finish("ply", colour_range);
  }

 private:
  static bool is_vertex(const PlyElement& element) {
    return element.name == "vertex" || element.name == "vertices";
  }

  void check_size(const PlyElement& element) const {
    const std::size_t least = element.least_row_bytes(header_.encoding);
    if (least > 0 && element.count > rows_.bytes_left() / least)
      rows_.fail("the header says " + std::to_string(element.count) + " rows of '" + element.name +
                     "', there are bytes for " + std::to_string(rows_.bytes_left() / least) + " at most",
                 kHintCut);
  }

  ColourRange read_vertices(const PlyElement& element) {
    const VertexColumns columns = find_columns(element);
    reserve(element, columns);
    Row row;
    row.scalars.resize(element.properties.size());
    bool quality_is_confidence = true;
    for (std::uint64_t i = 0; i < element.count; ++i) {
      rows_.next(element, row);
      const auto& s = row.scalars;
      builder_.add_position(s[columns.position[0]], s[columns.position[1]], s[columns.position[2]]);
      if (columns.has_normal)
        builder_.add_normal(s[columns.normal[0]], s[columns.normal[1]], s[columns.normal[2]]);
      if (columns.has_byte_colour)
        builder_.add_colour_bytes(clamp_to_byte(s[columns.colour[0]]), clamp_to_byte(s[columns.colour[1]]),
                                  clamp_to_byte(s[columns.colour[2]]));
      else if (columns.has_colour)
        builder_.add_colour(s[columns.colour[0]], s[columns.colour[1]], s[columns.colour[2]]);
      if (columns.confidence >= 0) builder_.add_confidence(s[columns.confidence]);
      if (columns.quality >= 0) {
        builder_.add_confidence(s[columns.quality]);
        quality_is_confidence &= s[columns.quality] >= 0.0 && s[columns.quality] <= 1.0;
      }
    }
    if (!quality_is_confidence) builder_.scan.points.confidences = {};
    return columns.colour_range;
  }

  void reserve(const PlyElement& element, const VertexColumns& columns) {
    const std::size_t count = element.count;
    builder_.reserve(count);
    if (columns.has_normal) builder_.scan.points.normals.reserve(count);
    if (columns.has_byte_colour) builder_.scan.points.colours.reserve(count);
    if (columns.confidence >= 0 || columns.quality >= 0) builder_.scan.points.confidences.reserve(count);
  }

  void read_faces(const PlyElement& element) {
    Row row;
    row.scalars.resize(element.properties.size());
    row.list_idx = element.find_property("vertex_indices");
    if (row.list_idx < 0) row.list_idx = element.find_property("vertex_index");
    const bool has_corners = row.list_idx >= 0 && element.properties[row.list_idx].is_list;
    if (has_corners) {
      const bool is_ascii = header_.encoding == PlyEncoding::ascii;
      const std::size_t index_bytes = is_ascii ? 2 : size_of(element.properties[row.list_idx].type);
      const std::size_t triangle_bytes = element.least_row_bytes(header_.encoding) + 3 * index_bytes;
      builder_.scan.triangles.reserve(
          std::min<std::uint64_t>(element.count, rows_.bytes_left() / triangle_bytes));
    }
    for (std::uint64_t i = 0; i < element.count && !element.properties.empty(); ++i) {
      rows_.next(element, row);
      if (has_corners) add_fan(row.list);
    }
  }

  void add_fan(const std::vector<double>& corners) {
    for (const double corner : corners)
      if (!(corner >= 0.0 && corner < static_cast<double>(vertex_count_)) || corner != std::floor(corner))
        rows_.fail("a face names a vertex beyond the " + std::to_string(vertex_count_) + " there are",
                   kHintDamaged);
    for (std::size_t k = 2; k < corners.size(); ++k)
      builder_.scan.triangles.emplace_back(static_cast<int>(corners[0]), static_cast<int>(corners[k - 1]),
                                           static_cast<int>(corners[k]));
  }

  void skip(const PlyElement& element) {
    Row row;
    row.scalars.resize(element.properties.size());
    for (std::uint64_t i = 0; i < element.count && !element.properties.empty(); ++i) rows_.next(element, row);
  }

  const PlyHeader& header_;
  const ScanLimits& limits_;
  Rows rows_;
  CloudBuilder builder_;
  std::uint64_t vertex_count_ = 0;
};

}  // namespace

ScanFile read_ply(std::span<const std::byte> bytes, const ScanLimits& limits) {
  const PlyHeader header = read_ply_header(bytes);
  switch (header.encoding) {
    case PlyEncoding::ascii:
      return PlyBody<AsciiRows>(bytes, header, limits).read();
    case PlyEncoding::little_endian:
      return PlyBody<BinaryRows<false>>(bytes, header, limits).read();
    case PlyEncoding::big_endian:
      return PlyBody<BinaryRows<true>>(bytes, header, limits).read();
  }
  throw FormatError("has an unknown PLY encoding (header)");
}

}  // namespace phiz::readers
