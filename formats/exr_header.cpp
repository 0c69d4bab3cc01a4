#include "formats/exr_header.h"

#include <cstdint>
#include <cstring>
#include <map>
#include <set>
#include <string>

#include "formats/error.h"

namespace phiz {
namespace {

constexpr std::uint64_t kMostValuesPerByte = 1040;  // deflate holds up to 1032 bytes in one

[[noreturn]] void fail(const std::string& what, std::size_t at) {
  throw FormatError(what + " (byte " + std::to_string(at) + ")");
}

/// Lengths of the types that have one; OpenEXR reads so many bytes whatever the file says.
std::uint32_t find_fixed_length(std::string_view type) {
  static const std::map<std::string_view, std::uint32_t> kLengths = {{"box2f", 16},
                                                                     {"box2i", 16},
                                                                     {"chromaticities", 32},
                                                                     {"compression", 1},
                                                                     {"deepImageState", 1},
                                                                     {"double", 8},
                                                                     {"envmap", 1},
                                                                     {"float", 4},
                                                                     {"int", 4},
                                                                     {"keycode", 28},
                                                                     {"lineOrder", 1},
                                                                     {"m33d", 72},
                                                                     {"m33f", 36},
                                                                     {"m44d", 128},
                                                                     {"m44f", 64},
                                                                     {"rational", 8},
                                                                     {"tiledesc", 9},
                                                                     {"timecode", 8},
                                                                     {"v2d", 16},
                                                                     {"v2f", 8},
                                                                     {"v2i", 8},
                                                                     {"v3d", 24},
                                                                     {"v3f", 12},
                                                                     {"v3i", 12}};
  const auto found = kLengths.find(type);
  return found == kLengths.end() ? 0 : found->second;
}

template <class Number>
Number read_number(std::string_view bytes, std::size_t at) {
  Number number{};
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

class HeaderCheck {
 public:
  explicit HeaderCheck(std::string_view bytes) : bytes_(bytes) {}

  void run() {
    constexpr std::uint32_t kTiled = 0x200, kDeepOrMultipart = 0x1800;
    if (!bytes_.starts_with("\x76\x2f\x31\x01") || bytes_.size() < 8) fail("is not an EXR file", 0);
    const auto version = read_number<std::uint32_t>(bytes_, 4);
    if ((version & kDeepOrMultipart) != 0) fail("is a deep or multi-part EXR", 4);
    if ((version & kTiled) != 0) fail("is a tiled EXR: only those of scan lines are read", 4);
    while (const auto name_length = measure_text()) read_attribute(take(name_length));
    ++at_;  // the empty name
    if (at_ >= bytes_.size()) throw FormatError("ends within its header");
    check_picture();
  }

 private:
  /// Length of the text that begins here, without its end.
  std::size_t measure_text() const {
    const std::size_t end = at_ < bytes_.size() ? bytes_.find('\0', at_) : std::string_view::npos;
    if (end == std::string_view::npos) throw FormatError("ends within its header");
    return end - at_;
  }

  std::string_view take(std::size_t text_length) {
    const std::string_view text = bytes_.substr(at_, text_length);
    at_ += text_length + 1;
    return text;
  }

  void read_attribute(std::string_view name) {
    const std::size_t begin = at_;
    const std::string_view type = take(measure_text());
    if (bytes_.size() - at_ < 4) throw FormatError("ends within its header");
    const auto length = read_number<std::uint32_t>(bytes_, at_);
    at_ += 4;
    if (length > bytes_.size() - at_) fail("an attribute claims too much", at_);
    if (!names_.insert(name).second) fail("two attributes of one name", begin);
    check_value(name, type, bytes_.substr(at_, length));
    at_ += length;
  }

  void check_value(std::string_view name, std::string_view type, std::string_view value) {
    const std::uint32_t fixed = find_fixed_length(type);
    if (fixed != 0 && value.size() != fixed)
      fail("attribute " + std::string(name) + " is of no such length", at_);
    if (type == "chlist") read_channels(value);
    if (type == "stringvector") check_texts(value);
    if (type == "idmanifest") fail("has an ID manifest, which is not read", at_);
    if (type == "preview") {
      const bool has_size = value.size() >= 8;
      const std::uint64_t pixels = has_size ? std::uint64_t{read_number<std::uint32_t>(value, 0)} *
                                                  read_number<std::uint32_t>(value, 4)
                                            : 0;
      if (!has_size || pixels > value.size() || 8 + 4 * pixels != value.size())
        fail("its preview has not the size it claims", at_);
    }
    if (name == "dataWindow" && type == "box2i") {
      const auto side = [&](std::size_t low, std::size_t high) {
        return std::int64_t{read_number<std::int32_t>(value, high)} - read_number<std::int32_t>(value, low) +
               1;
      };
      width_ = side(0, 8);
      height_ = side(4, 12);
    }
  }

  /// Name, type and sampling of each channel, and an empty name: nothing more, nothing less.
  void read_channels(std::string_view list) {
    constexpr std::size_t kAfterName = 16;
    std::size_t at = 0;
    while (at < list.size() && list[at] != '\0') {
      const std::size_t end = list.find('\0', at);
      if (end == std::string_view::npos || list.size() - end - 1 < kAfterName)
        fail("its channels are cut short", at_);
      at = end + 1 + kAfterName;
      ++channels_;
    }
    if (at + 1 != list.size()) fail("its channels are not as long as they claim", at_);
  }

  void check_texts(std::string_view texts) {
    while (!texts.empty()) {
      const bool has_length = texts.size() >= 4;
      const std::uint64_t length = has_length ? read_number<std::uint32_t>(texts, 0) : 0;
      if (!has_length || length > texts.size() - 4) fail("a list of texts is not as long as it claims", at_);
      texts.remove_prefix(4 + length);
    }
  }

  void check_picture() const {
    if (width_ < 1 || height_ < 1 || width_ > kLargestExrSide || height_ > kLargestExrSide) {
      throw FormatError("claims to be " + std::to_string(width_) + " x " + std::to_string(height_));
    }
    if (channels_ == 0) throw FormatError("has no channels");
    const auto pixels = static_cast<std::uint64_t>(width_ * height_);
    if (pixels * channels_ / kMostValuesPerByte > bytes_.size())
      throw FormatError("claims more than it holds");
  }

  std::string_view bytes_;
  std::size_t at_ = 8;
  std::set<std::string_view> names_;
  std::int64_t width_ = 0, height_ = 0;
  std::uint64_t channels_ = 0;
};

}  // namespace

void check_exr_header(std::string_view bytes) {
  HeaderCheck(bytes).run();
}

}  // namespace phiz
