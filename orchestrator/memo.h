#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

namespace phiz {

/// Things made from one subject's inputs that several of its stages need, made once a run: the parsed generic
/// head, a search tree over the cloud. The key must name the content (by digest) and every parameter, so that
/// what is remembered is what would be made anew. Not thread-safe: one subject's stages run one after the
/// other.
class Memo {
 public:
  template <class T>
  std::shared_ptr<const T> get(const std::string& key,
                               const std::function<std::shared_ptr<const T>()>& make) {
    std::shared_ptr<const void>& entry = entries_[key];
    if (!entry) entry = make();
    return std::static_pointer_cast<const T>(entry);
  }

  void clear() { entries_.clear(); }

 private:
  std::map<std::string, std::shared_ptr<const void>> entries_;
};

}  // namespace phiz
