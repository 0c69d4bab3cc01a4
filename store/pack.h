#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "store/store.h"

namespace phiz {

/// Some subjects of a store in one file: a plain tar (ustar; no times, owners or modes of ours), so that any
/// tar lists and extracts it. Members, in this order:
///   phiz-pack.json                sealed: format_version 1
///   objects/ab/cdef…, results/<key>.json, subjects/<number>.json    as they lie in the store
/// A subject comes with its current results, their outputs, and those of their inputs that are in the store.
/// Same subjects, same bytes, handed to `write` in order; never more than one object in memory. Throws
/// kMissing for an unknown subject, kDamaged for what is not whole: nothing damaged is packed.
using WritePack = std::function<void(std::string_view bytes)>;
void pack_subjects(const Store& store, const std::vector<std::string>& names, const WritePack& write);

/// The same as a whole.
std::string pack_subjects(const Store& store, const std::vector<std::string>& names);

/// Likewise into a file that is there whole and durable, or not at all. `check_stop` may throw. Returns its
/// length.
std::uint64_t pack_to_file(const Store& store, const std::vector<std::string>& names,
                           const std::filesystem::path& file, const std::function<void()>& check_stop = {});

struct UnpackOptions {
  bool replaces_subjects = false;  ///< a subject of the same name and another content is replaced
};

struct UnpackReport {
  std::vector<std::string> subjects;  ///< taken over
  std::uint64_t objects = 0, results = 0;
};

/// Takes over what a pack holds. Everything is checked before anything is written: digests, seals, names, and
/// that no path is any other than the above. Throws kDamaged for a file that is no whole pack, kExists for a
/// subject that is there with another content. What is there already is kept. `read` hands over the pack's
/// bytes from its beginning; it is called twice. Never more than one object in memory.
using ReadPack = std::function<void(const std::function<void(std::string_view bytes)>& take)>;
UnpackReport unpack_subjects(const Store& store, const ReadPack& read, const UnpackOptions& options = {});
UnpackReport unpack_subjects(const Store& store, std::string_view archive, const UnpackOptions& options = {});
UnpackReport unpack_file(const Store& store, const std::filesystem::path& file,
                         const UnpackOptions& options = {});

}  // namespace phiz
