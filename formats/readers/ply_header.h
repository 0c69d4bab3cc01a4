#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace phiz::readers {

enum class PlyType : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };
enum class PlyEncoding : std::uint8_t { ascii, little_endian, big_endian };

std::size_t size_of(PlyType type);

struct PlyProperty {
  std::string name;  ///< lower case
  PlyType type = PlyType::f32;
  bool is_list = false;
  PlyType count_type = PlyType::u8;  ///< of a list
};

struct PlyElement {
  std::string name;  ///< lower case
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_lists() const;
  /// Bytes of one row at least: all of them, where there are no lists.
  std::size_t least_row_bytes(PlyEncoding encoding) const;
  /// Position of a property, -1 if there is none.
  int find_property(const std::string& name) const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::ascii;
  std::vector<PlyElement> elements;
  std::size_t body_byte = 0;    ///< where the rows begin
  std::uint64_t body_line = 0;  ///< number of the first line of an ascii body
};

/// Throws FormatError with the line. Counts are as announced: compare them with the bytes before use.
PlyHeader read_ply_header(std::span<const std::byte> bytes);

}  // namespace phiz::readers
