#include "formats/readers/recognise.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "formats/readers/byte_order.h"
#include "formats/readers/fail.h"
#include "formats/readers/text_lines.h"

namespace phiz::readers {
namespace {

constexpr const char* kReads =
    "phiz reads PLY, OBJ, STL, OFF, XYZ/PTS/CSV text, GLB, Draco and OpenVDB points";

/// Files that are met among scans and are not read, by their first bytes.
void refuse_known_others(std::string_view text) {
  static constexpr std::pair<std::string_view, const char*> kOthers[] = {{"\x1F\x8B", "gzip data"},
                                                                         {"PK\x03\x04", "a zip archive"},
                                                                         {"\x28\xB5\x2F\xFD", "zstd data"},
                                                                         {"BZh", "bzip2 data"},
                                                                         {"\xFD"
                                                                          "7zXZ",
                                                                          "xz data"},
                                                                         {"7z\xBC\xAF", "a 7z archive"},
                                                                         {"LASF", "a LAS cloud"},
                                                                         {"ASTM-E57", "an E57 cloud"},
                                                                         {"# .PCD", "a PCD cloud"},
                                                                         {"Kaydara FBX", "an FBX scene"},
                                                                         {"\x89PNG", "a picture"},
                                                                         {"\xFF\xD8\xFF", "a picture"}};
  for (const auto& [mark, name] : kOthers) {
    if (!text.starts_with(mark)) continue;
    const bool is_packed =
        std::string_view(name).ends_with("data") || std::string_view(name).ends_with("archive");
    fail_at_byte(std::string("is ") + name + ", not a scan phiz can read", 0,
                 is_packed ? "unpack it first" : kReads);
  }
}

bool has_stl_size(std::span<const std::byte> bytes) {
  if (bytes.size() < 84) return false;
  const std::uint64_t facets = load<std::uint32_t>(bytes.data() + 80);
  return facets > 0 && bytes.size() == 84 + 50 * facets;
}

bool is_off_keyword(std::string_view word) {
  if (word.starts_with("ST")) word.remove_prefix(2);
  while (!word.empty() && (word[0] == 'C' || word[0] == 'N' || word[0] == '4' || word[0] == 'n'))
    word.remove_prefix(1);
  return word.starts_with("OFF");
}

bool is_obj_keyword(std::string_view word) {
  static constexpr std::string_view kWords[] = {"v", "vn", "vt", "vp", "f",      "o",
                                                "g", "s",  "l",  "p",  "mtllib", "usemtl"};
  return std::find(std::begin(kWords), std::end(kWords), word) != std::end(kWords);
}

/// By the first line that is not a comment.
std::optional<ScanFormat> recognise_text(std::span<const std::byte> bytes) {
  constexpr std::size_t kLookAhead = 65536;
  TextLines lines(bytes.first(std::min(bytes.size(), kLookAhead)));
  std::string_view line;
  while (lines.next_filled(line)) {
    Fields fields(line, lines.number());
    const std::string_view word = fields.next_word();
    if (word.starts_with('#') || word.starts_with("//")) continue;
    if (equals_lower(word, "solid")) return ScanFormat::stl_ascii;
    if (is_off_keyword(word)) return ScanFormat::off;
    if (is_obj_keyword(word)) return ScanFormat::obj;
    if (word.starts_with('{')) fail_at_byte("is JSON, perhaps .gltf", 0, "export as one .glb file");
    double ignored = 0.0;
    const char* stop = parse_number(word.data(), word.data() + word.size(), ignored);
    const bool is_number = stop && (stop == word.data() + word.size() || *stop == ',' || *stop == ';');
    return is_number ? std::optional(ScanFormat::text) : std::nullopt;
  }
  return std::nullopt;
}

std::optional<ScanFormat> recognise_extension(const std::string& extension) {
  static constexpr std::pair<std::string_view, ScanFormat> kExtensions[] = {
      {".ply", ScanFormat::ply},   {".obj", ScanFormat::obj},     {".stl", ScanFormat::stl_binary},
      {".off", ScanFormat::off},   {".coff", ScanFormat::off},    {".noff", ScanFormat::off},
      {".xyz", ScanFormat::text},  {".pts", ScanFormat::text},    {".csv", ScanFormat::text},
      {".txt", ScanFormat::text},  {".asc", ScanFormat::text},    {".tsv", ScanFormat::text},
      {".xyzn", ScanFormat::text}, {".xyzrgb", ScanFormat::text}, {".glb", ScanFormat::glb},
      {".drc", ScanFormat::drc},   {".vdb", ScanFormat::vdb}};
  for (const auto& [name, format] : kExtensions)
    if (equals_lower(extension, name)) return format;
  return std::nullopt;
}

/// A header line of names is known by the extension only.
bool is_binary(std::string_view text) {
  return text.substr(0, 4096).find('\0') != std::string_view::npos;
}

}  // namespace

ScanFormat recognise(std::span<const std::byte> bytes, const std::string& extension) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.starts_with("ply") && (text.size() == 3 || text[3] == '\n' || text[3] == '\r'))
    return ScanFormat::ply;
  if (text.starts_with("glTF")) return ScanFormat::glb;
  if (text.starts_with("DRACO")) return ScanFormat::drc;
  if (text.starts_with(std::string_view(" BDV\0\0\0\0", 8))) return ScanFormat::vdb;
  if (has_stl_size(bytes)) return ScanFormat::stl_binary;
  refuse_known_others(text);
  const std::optional<ScanFormat> by_extension = recognise_extension(extension);
  const bool is_stl = by_extension == ScanFormat::stl_binary;
  if (is_stl && is_binary(text)) return ScanFormat::stl_binary;
  if (!is_binary(text))
    if (const auto by_text = recognise_text(bytes)) return *by_text;
  switch (by_extension.value_or(ScanFormat::glb)) {
    case ScanFormat::ply:
      fail_at_byte("does not begin with 'ply'", 0, "is it another format under this name?");
    case ScanFormat::glb:
    case ScanFormat::drc:
    case ScanFormat::vdb:
      break;
    default:
      return *by_extension;
  }
  fail_at_byte(by_extension ? "does not begin like a " + extension + " file" : "is no format phiz knows", 0,
               kReads);
}

}  // namespace phiz::readers
