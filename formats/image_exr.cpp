#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <half.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "formats/content_seal.h"
#include "formats/error.h"
#include "formats/exr_header.h"
#include "formats/image.h"
#include "formats/text.h"

namespace phiz {
namespace {

constexpr int kLargestSide = kLargestExrSide;
constexpr const char* kSealName = "phizSeal";
constexpr std::size_t kSealLength = 64;

class MemoryWriter : public Imf::OStream {
 public:
  MemoryWriter() : OStream("memory") {}
  void write(const char* data, int length) override {
    const auto count = static_cast<std::size_t>(length);
    if (at_ + count > bytes.size()) bytes.resize(at_ + count);
    std::memcpy(bytes.data() + at_, data, count);
    at_ += count;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t at) override { at_ = at; }

  std::string bytes;

 private:
  std::size_t at_ = 0;
};

class MemoryReader : public Imf::IStream {
 public:
  explicit MemoryReader(const std::string& bytes) : IStream("memory"), bytes_(bytes) {}
  bool read(char* data, int length) override {
    if (length < 0 || at_ > bytes_.size() || bytes_.size() - at_ < static_cast<std::size_t>(length)) {
      throw FormatError("ends early (byte " + std::to_string(bytes_.size()) + ")");
    }
    std::memcpy(data, bytes_.data() + at_, static_cast<std::size_t>(length));
    at_ += static_cast<std::size_t>(length);
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t at) override { at_ = at; }

 private:
  const std::string& bytes_;
  std::size_t at_ = 0;
};

bool is_half(const std::string& channel) {
  return channel.starts_with("N.") || channel.starts_with("Cd.");
}

/// Attributes that mean something to OpenEXR although they may be strings.
bool is_reserved(const std::string& name) {
  static const Imf::Header standard;
  constexpr std::array<const char*, 7> kMore{"type",  "name",       "version", "view",
                                             "tiles", "chunkCount", kSealName};
  return standard.find(name.c_str()) != standard.end() ||
         std::find(kMore.begin(), kMore.end(), name) != kMore.end();
}

bool is_name(const std::string& name) {
  return !name.empty() && name.size() <= 255 && name.find('\0') == std::string::npos;
}

void check_image(const FloatImage& image) {
  const bool sized = image.width > 0 && image.height > 0 && image.width <= kLargestSide &&
                     image.height <= kLargestSide && !image.channels.empty();
  if (!sized) throw FormatError("image is empty or above 16384");
  for (const auto& [name, values] : image.channels) {
    if (!is_name(name)) throw FormatError("'" + name + "' cannot be a channel's name");
    if (values.size() != static_cast<std::size_t>(image.width) * image.height) {
      throw FormatError("channel " + name + " is not of the image's size");
    }
    const float largest = is_half(name) ? 65504.0f : std::numeric_limits<float>::max();
    const auto bad =
        std::find_if(values.begin(), values.end(), [&](float v) { return !(std::abs(v) <= largest); });
    if (bad != values.end()) {
      throw FormatError("channel " + name + " is not finite (value " + std::to_string(bad - values.begin()) +
                        ")");
    }
  }
  for (const auto& [name, value] : image.attributes) {
    if (!is_name(name) || is_reserved(name))
      throw FormatError("'" + name + "' cannot be an attribute's name");
    if (value.find('\0') != std::string::npos) throw FormatError("attribute " + name + " is no text");
  }
}

std::string encode(const FloatImage& image) {
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  header.insert(kSealName, Imf::StringAttribute(std::string(kSealLength, '0')));
  for (const auto& [name, value] : image.attributes) header.insert(name, Imf::StringAttribute(value));
  Imf::FrameBuffer buffer;
  std::map<std::string, std::vector<half>> halves;
  const auto width = static_cast<std::size_t>(image.width);
  for (const auto& [name, values] : image.channels) {
    const Imf::PixelType type = is_half(name) ? Imf::HALF : Imf::FLOAT;
    header.channels().insert(name, Imf::Channel(type));
    if (type == Imf::HALF) {
      std::vector<half>& rows = halves[name];
      rows.assign(values.begin(), values.end());
      buffer.insert(name, Imf::Slice(type, reinterpret_cast<char*>(rows.data()), 2, 2 * width));
    } else {
      char* rows = reinterpret_cast<char*>(const_cast<float*>(values.data()));  // only read from
      buffer.insert(name, Imf::Slice(type, rows, 4, 4 * width));
    }
  }
  MemoryWriter stream;
  {
    Imf::OutputFile file(stream, header, 0);
    file.setFrameBuffer(buffer);
    file.writePixels(image.height);
  }
  return std::move(stream.bytes);
}

/// Where the 64 digits of the seal stand, npos if there is none.
std::size_t find_seal(const std::string& bytes) {
  const std::string entry = kSealName + std::string("\0string\0\x40\0\0\0", 12);
  const std::size_t at = bytes.find(entry);
  const bool whole = at != std::string::npos && at + entry.size() + kSealLength <= bytes.size();
  return whole ? at + entry.size() : std::string::npos;
}

FloatImage decode(const std::string& bytes) {
  static const bool limited = (Imf::Header::setMaxImageSize(kLargestSide, kLargestSide), true);
  static_cast<void>(limited);
  check_exr_header(bytes);
  MemoryReader stream(bytes);
  Imf::InputFile file(stream, 0);
  const Imf::Header& header = file.header();
  const Imath::Box2i window = header.dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide) {
    throw FormatError("claims to be " + std::to_string(width) + " x " + std::to_string(height));
  }
  FloatImage image{static_cast<int>(width), static_cast<int>(height), {}, {}};
  const auto pixel_count = static_cast<std::size_t>(width * height);
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
    if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1) {
      throw FormatError(std::string("channel ") + channel.name() + " is subsampled");
    }
  }
  Imf::FrameBuffer buffer;
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
    std::vector<float>& values = image.channels[channel.name()];
    values.resize(pixel_count);
    buffer.insert(channel.name(), Imf::Slice::Make(Imf::FLOAT, values.data(), window));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  for (auto attribute = header.begin(); attribute != header.end(); ++attribute) {
    const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute.attribute());
    if (text != nullptr && !is_reserved(attribute.name())) image.attributes[attribute.name()] = text->value();
  }
  return image;
}

}  // namespace

void write_exr(const FloatImage& image, std::ostream& out) {
  check_image(image);
  std::string bytes;
  try {
    bytes = encode(image);
  } catch (const std::exception& error) {
    throw FormatError(std::string("OpenEXR cannot write: ") + error.what());
  }
  const std::size_t seal = find_seal(bytes);
  bytes.replace(seal, kSealLength, digest_without(bytes, seal, kSealLength));
  write_all(out, bytes);
}

FloatImage read_exr(std::istream& in) {
  const std::string bytes = read_all(in);
  const std::size_t seal = find_seal(bytes);
  if (seal != std::string::npos &&
      bytes.substr(seal, kSealLength) != digest_without(bytes, seal, kSealLength)) {
    throw FormatError("is damaged: its content does not match its seal (byte " + std::to_string(seal) + ")");
  }
  try {
    return decode(bytes);
  } catch (const FormatError&) {
    throw;
  } catch (const std::exception& error) {
    throw FormatError(std::string("OpenEXR cannot read: ") + error.what());
  }
}

}  // namespace phiz
