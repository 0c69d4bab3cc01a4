#pragma once

#include <atomic>

#include "orchestrator/error.h"

namespace phiz {

/// Set by SIGINT and SIGTERM, read at safe points. Lock-free, so that a signal handler may set it.
class StopFlag {
 public:
  void request(int signal) { signal_.store(signal); }
  int signal() const { return signal_.load(); }  ///< 0: go on
  void throw_if_requested() const {
    if (const int signal_number = signal()) throw Interrupted(signal_number);
  }

 private:
  std::atomic<int> signal_ = 0;
  static_assert(std::atomic<int>::is_always_lock_free);
};

}  // namespace phiz
