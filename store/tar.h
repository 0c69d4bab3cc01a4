#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace phiz {

constexpr std::size_t kTarBlock = 512;

/// The header of a plain file in a tar (ustar; no time, owner or mode of ours). The bytes follow it, then
/// tar_padding(size) zeros; two blocks of zeros end the archive. `name` has at most 100 bytes, the file less
/// than 8 GiB.
std::string make_tar_header(const std::string& name, std::uint64_t size_bytes);
std::size_t tar_padding(std::uint64_t size_bytes);

/// Takes a tar apart as its bytes come, in blocks of any length; holds one header and nothing else. Throws
/// StoreError kDamaged for what make_tar_header does not make.
class TarReader {
 public:
  struct Handler {
    std::function<void(const std::string& name, std::uint64_t size_bytes)> begin;
    std::function<void(std::string_view bytes)> take;  ///< as often as it takes; never for an empty member
    std::function<void()> end;
  };
  explicit TarReader(Handler handler) : handler_(std::move(handler)) {}

  void feed(std::string_view bytes);
  void finish() const;  ///< throws if the archive has not come to its end

 private:
  void read_header();

  Handler handler_;
  std::array<char, kTarBlock> header_{};
  std::size_t header_bytes_ = 0;
  std::uint64_t data_left_ = 0, padding_left_ = 0;
  bool is_over_ = false;
};

}  // namespace phiz
