#include "store/tar.h"

#include <fmt/format.h>

#include <algorithm>

#include "store/error.h"

namespace phiz {
namespace {

constexpr std::size_t kNameBytes = 100, kSizeAt = 124, kSizeDigits = 11, kSumAt = 148, kSumBytes = 8,
                      kTypeAt = 156;

unsigned sum_of(std::string_view header) {
  unsigned sum = 0;
  for (std::size_t i = 0; i < kTarBlock; ++i) {
    const bool is_sum = i >= kSumAt && i < kSumAt + kSumBytes;
    sum += is_sum ? ' ' : static_cast<unsigned char>(header[i]);
  }
  return sum;
}

[[noreturn]] void fail(const std::string& what) {
  throw StoreError(StoreFault::kDamaged, "the pack: " + what);
}

std::uint64_t parse_octal(std::string_view digits) {
  std::uint64_t value = 0;
  for (const char c : digits) {
    if (c < '0' || c > '7') fail("a length is not one");
    value = 8 * value + static_cast<std::uint64_t>(c - '0');
  }
  return value;
}

}  // namespace

std::size_t tar_padding(std::uint64_t size_bytes) {
  return static_cast<std::size_t>((kTarBlock - size_bytes % kTarBlock) % kTarBlock);
}

std::string make_tar_header(const std::string& name, std::uint64_t size_bytes) {
  if (name.size() > kNameBytes || size_bytes >= std::uint64_t{1} << 33)
    throw StoreError(StoreFault::kIo, name + ": too long for a pack");
  std::string header(kTarBlock, '\0');
  const auto put = [&](std::size_t at, const std::string& text) { header.replace(at, text.size(), text); };
  put(0, name);
  put(100, "0000444");
  put(108, "0000000");
  put(116, "0000000");
  put(kSizeAt, fmt::format("{:011o}", size_bytes));
  put(136, "00000000000");
  put(kTypeAt, "0");
  put(257, std::string("ustar\0", 6) + "00");
  put(kSumAt, fmt::format("{:06o}", sum_of(header)) + std::string("\0 ", 2));
  return header;
}

void TarReader::feed(std::string_view bytes) {
  while (!bytes.empty() && !is_over_) {
    if (data_left_ > 0) {
      const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(data_left_, bytes.size()));
      handler_.take(bytes.substr(0, size));
      bytes.remove_prefix(size);
      data_left_ -= size;
      if (data_left_ == 0) handler_.end();
    } else if (padding_left_ > 0) {
      const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(padding_left_, bytes.size()));
      bytes.remove_prefix(size);
      padding_left_ -= size;
    } else {
      const std::size_t size = std::min(kTarBlock - header_bytes_, bytes.size());
      std::copy_n(bytes.data(), size, header_.data() + header_bytes_);
      bytes.remove_prefix(size);
      header_bytes_ += size;
      if (header_bytes_ == kTarBlock) read_header();
    }
  }
}

void TarReader::read_header() {
  header_bytes_ = 0;
  const std::string_view header(header_.data(), header_.size());
  if (header.find_first_not_of('\0') == std::string_view::npos) {
    is_over_ = true;
    return;
  }
  if (parse_octal(header.substr(kSumAt, 6)) != sum_of(header)) fail("a header's sum is wrong");
  if (header[kTypeAt] != '0') fail("a member that is no plain file");
  data_left_ = parse_octal(header.substr(kSizeAt, kSizeDigits));
  padding_left_ = tar_padding(data_left_);
  const std::string_view name = header.substr(0, kNameBytes);
  handler_.begin(std::string(name.substr(0, name.find('\0'))), data_left_);
  if (data_left_ == 0) handler_.end();
}

void TarReader::finish() const {
  if (!is_over_) fail("cut short");
}

}  // namespace phiz
