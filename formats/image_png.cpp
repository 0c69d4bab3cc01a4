#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <string_view>

#include "formats/error.h"
#include "formats/image.h"
#include "formats/text.h"

namespace phiz {
namespace {

constexpr int kLargestSide = 16384;
constexpr int kZlibLevel = 6;
constexpr unsigned char kFilterUp = 2;

void append_big_endian(std::string& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xff);
}

void append_chunk(std::string& bytes, std::string_view type, std::string_view data) {
  append_big_endian(bytes, static_cast<std::uint32_t>(data.size()));
  const std::size_t begin = bytes.size();
  (bytes += type) += data;
  const auto* covered = reinterpret_cast<const Bytef*>(bytes.data() + begin);
  append_big_endian(bytes, static_cast<std::uint32_t>(crc32_z(0, covered, bytes.size() - begin)));
}

/// Rows as differences to the row above, each led by its filter's number.
std::string filter_rows(const Image& image) {
  const std::size_t row_bytes = static_cast<std::size_t>(image.width) * 3;
  const auto* pixels = reinterpret_cast<const unsigned char*>(image.pixels.data());
  std::string rows;
  rows.reserve((row_bytes + 1) * static_cast<std::size_t>(image.height));
  for (std::size_t y = 0; y < static_cast<std::size_t>(image.height); ++y) {
    rows += static_cast<char>(kFilterUp);
    for (std::size_t i = 0; i < row_bytes; ++i) {
      const unsigned char above = y > 0 ? pixels[(y - 1) * row_bytes + i] : 0;
      rows += static_cast<char>(pixels[y * row_bytes + i] - above);
    }
  }
  return rows;
}

std::string deflate_fixed(const std::string& data) {
  uLongf length = compressBound(data.size());
  std::string packed(length, '\0');
  const int status = compress2(reinterpret_cast<Bytef*>(packed.data()), &length,
                               reinterpret_cast<const Bytef*>(data.data()), data.size(), kZlibLevel);
  if (status != Z_OK) throw FormatError("picture could not be compressed");
  packed.resize(length);
  return packed;
}

}  // namespace

void write_png(const Image& image, std::ostream& out) {
  const bool sized = image.width > 0 && image.height > 0 && image.width <= kLargestSide &&
                     image.height <= kLargestSide &&
                     image.pixels.size() == static_cast<std::size_t>(image.width) * image.height;
  if (!sized) throw FormatError("picture is empty, above 16384 or not of its own size");
  std::string header;
  append_big_endian(header, static_cast<std::uint32_t>(image.width));
  append_big_endian(header, static_cast<std::uint32_t>(image.height));
  header += std::string_view("\x08\x02\0\0\0", 5);  // 8 bits, RGB, deflate, adaptive filters, not interlaced
  std::string bytes = "\x89PNG\r\n\x1a\n";
  append_chunk(bytes, "IHDR", header);
  append_chunk(bytes, "sRGB", std::string_view("\0", 1));
  append_chunk(bytes, "IDAT", deflate_fixed(filter_rows(image)));
  append_chunk(bytes, "IEND", "");
  write_all(out, bytes);
}

Image read_png(std::istream& in) {
  const std::string bytes = read_all(in);
  png_image reader{};
  reader.version = PNG_IMAGE_VERSION;
  const auto fail = [&reader](const std::string& what) {
    const FormatError error(what + (reader.message[0] != '\0' ? ": " + std::string(reader.message) : ""));
    png_image_free(&reader);
    throw error;
  };
  if (png_image_begin_read_from_memory(&reader, bytes.data(), bytes.size()) == 0) fail("is not a PNG");
  // A deflated byte holds at most 1032, and a pixel has at least one bit.
  const std::uint64_t pixel_count = std::uint64_t{reader.width} * reader.height;
  if (reader.width > kLargestSide || reader.height > kLargestSide ||
      pixel_count / (8 * 1032) > bytes.size()) {
    fail("claims to be " + std::to_string(reader.width) + " x " + std::to_string(reader.height));
  }
  Image image{static_cast<int>(reader.width), static_cast<int>(reader.height), {}};
  image.pixels.resize(pixel_count);
  reader.format = PNG_FORMAT_RGB;
  const png_color white{255, 255, 255};
  if (png_image_finish_read(&reader, &white, image.pixels.data(), 0, nullptr) == 0) fail("is a broken PNG");
  png_image_free(&reader);
  return image;
}

}  // namespace phiz
