#include "store/checkpoint.h"

#include "store/error.h"

namespace phiz {
namespace {

constexpr std::string_view kHeader = "phiz-checkpoint 1 ";

std::optional<std::string> unpack(const std::string& text) {
  constexpr std::size_t kHeaderBytes = kHeader.size() + 64 + 1;
  if (text.size() < kHeaderBytes || !text.starts_with(kHeader) || text[kHeaderBytes - 1] != '\n') {
    return std::nullopt;
  }
  std::string bytes = text.substr(kHeaderBytes);
  if (compute_digest(bytes).hex() != text.substr(kHeader.size(), 64)) return std::nullopt;
  return bytes;
}

}  // namespace

bool is_whole_checkpoint(const std::string& text) {
  return unpack(text).has_value();
}

void Checkpoint::save(std::span<const std::byte> bytes) const {
  std::string text(kHeader);
  text += compute_digest(bytes).hex() + "\n";
  text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  DurableWriter writer(store_->files());
  writer.make_folder(store_->layout().checkpoint(key_));
  writer.add(file(), std::as_bytes(std::span(text)), FileSystem::Mode::kWritable);
  writer.publish();
}

std::optional<std::string> Checkpoint::load() const {
  if (!store_->files().find_status(file())) return std::nullopt;
  auto bytes = unpack(store_->files().read_file(file()));
  if (!bytes) store_->files().remove_file(file());
  return bytes;
}

void Checkpoint::remove() const {
  FileSystem& files = store_->files();
  const std::filesystem::path folder = store_->layout().checkpoint(key_);
  if (!files.find_status(folder)) return;
  for (const std::string& name : files.list_folder(folder)) files.remove_file(folder / name);
  files.remove_folder(folder);
}

}  // namespace phiz
