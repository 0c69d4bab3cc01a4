#pragma once

#include <stdexcept>
#include <string>

namespace phiz {

/// What kind of thing went wrong in the store or at the door to the operating system.
enum class StoreFault {
  kMissing,         ///< no such file or folder
  kExists,          ///< something is there already
  kNoStore,         ///< the folder is no store
  kUnknownVersion,  ///< a store of a version this program does not know
  kDamaged,         ///< bytes that do not match their digest or their seal
  kFull,            ///< disk or quota full
  kPermission,      ///< not allowed, read-only
  kLeaseHeld,       ///< another living process computes this now
  kInvalidName,     ///< a name that may not become a file name
  kIo,              ///< anything else the operating system reported
};

/// The store could not do its job. `what()` is one line that names the file; `hint` says how to go on, may be
/// empty.
class StoreError : public std::runtime_error {
 public:
  StoreError(StoreFault fault, const std::string& what, std::string hint = {})
      : std::runtime_error(what), fault_(fault), hint_(std::move(hint)) {}
  StoreFault fault() const { return fault_; }
  const std::string& hint() const { return hint_; }

 private:
  StoreFault fault_;
  std::string hint_;
};

}  // namespace phiz
