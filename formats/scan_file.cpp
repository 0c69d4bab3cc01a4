#include "formats/scan_file.h"

#include <new>

#include "formats/error.h"
#include "formats/readers/file_bytes.h"
#include "formats/readers/readers.h"
#include "formats/readers/recognise.h"

namespace phiz {
namespace {

ScanFile parse_as(readers::ScanFormat format, std::span<const std::byte> bytes, const ScanLimits& limits) {
  using readers::ScanFormat;
  switch (format) {
    case ScanFormat::ply:
      return readers::read_ply(bytes, limits);
    case ScanFormat::obj:
      return readers::read_obj(bytes, limits);
    case ScanFormat::stl_binary:
      return readers::read_stl_binary(bytes, limits);
    case ScanFormat::stl_ascii:
      return readers::read_stl_ascii(bytes, limits);
    case ScanFormat::off:
      return readers::read_off(bytes, limits);
    case ScanFormat::text:
      return readers::read_text(bytes, limits);
    case ScanFormat::glb:
      return readers::read_glb(bytes, limits);
    case ScanFormat::drc:
      return readers::read_drc(bytes, limits);
    case ScanFormat::vdb:
      return readers::read_vdb(bytes, limits);
  }
  throw FormatError("is no format phiz knows");
}

}  // namespace

ScanFile parse_scan(std::span<const std::byte> bytes, const std::string& extension,
                    const ScanLimits& limits) {
  if (bytes.empty()) throw FormatError("is empty (byte 0)", "was the scan saved to the end?");
  try {
    return parse_as(readers::recognise(bytes, extension), bytes, limits);
  } catch (const std::bad_alloc&) {
    throw FormatError("does not fit in memory (" + std::to_string(bytes.size()) + " bytes)",
                      "thin the scan first");
  }
}

ScanFile read_scan_file(const std::filesystem::path& path, const ScanLimits& limits) {
  try {
    const readers::FileBytes bytes = readers::read_file_bytes(path);
    return parse_scan(bytes.view(), path.extension().string(), limits);
  } catch (const FormatError& error) {
    throw FormatError(path.string() + ": " + error.what(), error.hint());
  }
}

}  // namespace phiz
