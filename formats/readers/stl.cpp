// STL, binary and ascii: a soup of triangles, each with three vertices of its own.
#include <algorithm>
#include <string>

#include "formats/readers/byte_order.h"
#include "formats/readers/cloud_builder.h"
#include "formats/readers/fail.h"
#include "formats/readers/readers.h"
#include "formats/readers/text_lines.h"

namespace phiz::readers {
namespace {

constexpr std::size_t kHeaderBytes = 84;  // 80 of text, then the number of triangles
constexpr std::size_t kFacetBytes = 50;   // normal, three vertices, 16 bits of anything

/// Polygons do not occur in STL, but a loop with more vertices has only one meaning.
void add_fan(CloudBuilder& builder, std::size_t first_idx) {
  const int first = static_cast<int>(first_idx), count = static_cast<int>(builder.size());
  for (int k = first + 2; k < count; ++k) builder.scan.triangles.emplace_back(first, k - 1, k);
}

class AsciiStl {
 public:
  AsciiStl(std::span<const std::byte> bytes, const ScanLimits& limits) : lines_(bytes), limits_(limits) {
    constexpr std::size_t kLeastFacetBytes = 80;  // the keywords alone are longer
    const std::size_t facets = bytes.size() / kLeastFacetBytes;
    builder_.reserve(3 * facets);
    builder_.scan.triangles.reserve(facets);
  }

  ScanFile read() {
    std::string_view line;
    while (lines_.next_filled(line)) {
      Fields fields(line, lines_.number());
      take(fields.next_word(), fields);
    }
    if (is_in_loop_ || is_in_solid_) fail("the text ends within a solid", kHintCut);
    return builder_.finish("stl");
  }

 private:
  void take(std::string_view keyword, Fields& fields) {
    if (equals_lower(keyword, "vertex")) {
      take_vertex(fields);
    } else if (equals_lower(keyword, "outer")) {
      if (is_in_loop_) fail("a loop begins within a loop", kHintDamaged);
      is_in_loop_ = true;
      loop_first_ = builder_.size();
    } else if (equals_lower(keyword, "endloop")) {
      if (!is_in_loop_ || builder_.size() < loop_first_ + 3)
        fail("a loop has less than three vertices", kHintDamaged);
      add_fan(builder_, loop_first_);
      is_in_loop_ = false;
    } else if (equals_lower(keyword, "solid") || equals_lower(keyword, "endsolid")) {
      if (is_in_loop_) fail("a loop does not end", kHintDamaged);
      is_in_solid_ = equals_lower(keyword, "solid");
    } else if (!equals_lower(keyword, "facet") && !equals_lower(keyword, "endfacet")) {
      fail(quoted(keyword) + " is no STL keyword", kHintDamaged);
    }
  }

  void take_vertex(Fields& fields) {
    if (!is_in_loop_) fail("a vertex stands outside a loop", kHintDamaged);
    const double x = fields.number("x"), y = fields.number("y"), z = fields.number("z");
    if (!fields.at_end()) fail("a vertex has more than three coordinates", kHintDamaged);
    CloudBuilder::check_count(builder_.size() + 1, limits_, "vertex lines");
    builder_.add_position(x, y, z);
  }

  [[noreturn]] void fail(const std::string& fault, const std::string& hint) const {
    fail_at_line(fault, lines_.number(), hint);
  }

  TextLines lines_;
  const ScanLimits& limits_;
  CloudBuilder builder_;
  bool is_in_solid_ = false, is_in_loop_ = false;
  std::size_t loop_first_ = 0;
};

}  // namespace

ScanFile read_stl_binary(std::span<const std::byte> bytes, const ScanLimits& limits) {
  if (bytes.size() < kHeaderBytes) fail_at_byte("the STL header is cut", bytes.size(), kHintCut);
  const std::uint64_t facets = load<std::uint32_t>(bytes.data() + 80);
  const std::size_t there = (bytes.size() - kHeaderBytes) / kFacetBytes;
  if (facets > there)
    fail_at_byte("the header says " + std::to_string(facets) + " triangles, there are bytes for " +
                     std::to_string(there),
                 80, kHintCut);
  CloudBuilder::check_count(3 * facets, limits);
  CloudBuilder builder;
  builder.reserve(3 * facets);
  builder.scan.triangles.reserve(facets);
  for (std::size_t i = 0; i < facets; ++i) {
    const std::byte* facet = bytes.data() + kHeaderBytes + i * kFacetBytes;
    const std::size_t first = builder.size();
    for (std::size_t corner = 1; corner <= 3; ++corner)  // the first three numbers are the facet's normal
      builder.add_position(static_cast<double>(load<float>(facet + 12 * corner)),
                           static_cast<double>(load<float>(facet + 12 * corner + 4)),
                           static_cast<double>(load<float>(facet + 12 * corner + 8)));
    add_fan(builder, first);
  }
  return builder.finish("stl");
}

ScanFile read_stl_ascii(std::span<const std::byte> bytes, const ScanLimits& limits) {
  return AsciiStl(bytes, limits).read();
}

}  // namespace phiz::readers
