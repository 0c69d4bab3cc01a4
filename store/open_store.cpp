#include <nlohmann/json.hpp>

#include "store/error.h"
#include "store/sealed_json.h"
#include "store/store.h"

namespace phiz {
namespace {

constexpr int kFormatVersion = 1;
constexpr std::uint64_t kMaxMarkerBytes = 1 << 16;

void check_version(FileSystem& files, const std::filesystem::path& marker) {
  const std::string text = files.read_file(marker, kMaxMarkerBytes);
  if (!is_sealed_well(text)) {
    throw StoreError(StoreFault::kDamaged, marker.string() + ": its bytes are not what was written",
                     "phiz store verify --repair writes it anew");
  }
  const nlohmann::json object = unseal_json(text, marker.string());
  const auto version = object.find("format_version");
  if (version == object.end() || !version->is_number_integer()) {
    throw StoreError(StoreFault::kDamaged, marker.string() + ": it names no format version");
  }
  if (*version != kFormatVersion) {
    throw StoreError(StoreFault::kUnknownVersion,
                     marker.string() + ": format version " + version->dump() + ", this program knows " +
                         std::to_string(kFormatVersion),
                     "use the program that made the store, or another --store");
  }
}

bool is_fresh_folder(FileSystem& files, const StoreLayout& layout) {
  // Folders of a store whose making was interrupted before the marker count as fresh.
  for (const std::string& name : files.list_folder(layout.root)) {
    const auto path = layout.root / name;
    const bool ours = path == layout.objects() || path == layout.results() || path == layout.subjects() ||
                      path == layout.checkpoints() || path == layout.leases() || path == layout.logs() ||
                      path == layout.marker() ||  // another process was quicker just now
                      is_temporary_name(name);
    if (!ours) return false;
  }
  return true;
}

void write_marker(FileSystem& files, const StoreLayout& layout) {
  const std::string marker = seal_json({{"format_version", kFormatVersion}, {"created_by", "phiz"}});
  DurableWriter writer(files);
  writer.add(layout.marker(), std::as_bytes(std::span(marker)), FileSystem::Mode::kWritable);
  writer.publish();
}

}  // namespace

bool Store::repair_marker(FileSystem& files, const std::filesystem::path& root) {
  try {
    open(files, root);
    return false;
  } catch (const StoreError& error) {
    if (error.fault() != StoreFault::kDamaged) throw;
  }
  const Store store(files, root);
  store.set_aside(store.layout_.marker());
  write_marker(files, store.layout_);
  return true;
}

Store Store::open(FileSystem& files, const std::filesystem::path& root) {
  Store store(files, root);
  if (!files.find_status(store.layout_.marker())) {
    throw StoreError(StoreFault::kNoStore, root.string() + ": no store there",
                     "name one with --store DIR or PHIZ_STORE; `phiz fit` makes it");
  }
  check_version(files, store.layout_.marker());
  return store;
}

Store Store::open_or_create(FileSystem& files, const std::filesystem::path& root) {
  Store store(files, root);
  const StoreLayout& layout = store.layout_;
  if (!files.find_status(layout.marker())) {
    files.make_folders(root);
    if (!is_fresh_folder(files, layout)) {
      throw StoreError(StoreFault::kNoStore,
                       root.string() + ": a folder with other things in it, and no store",
                       "name an empty or a new folder with --store DIR");
    }
    for (const auto& folder : {layout.objects(), layout.results(), layout.subjects(), layout.checkpoints(),
                               layout.leases(), layout.logs()}) {
      files.make_folder(folder);
    }
    files.sync_folder(root);  // the marker must not survive what it vouches for
    write_marker(files, layout);
  }
  check_version(files, layout.marker());
  return store;
}

}  // namespace phiz
