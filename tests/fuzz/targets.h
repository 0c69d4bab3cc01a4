#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

namespace phiz::fuzz {

/// One reader of hostile bytes. It returns, or throws an exception of ours that says what is wrong with the
/// bytes; anything else (a crash, std::bad_alloc, a contract violation) is a finding.
struct Target {
  std::string_view name;  ///< also the folder of its corpus
  void (*read)(const std::string& bytes);
};

std::span<const Target> list_targets();
const Target* find_target(std::string_view name);

/// Runs it; exceptions that a reader may throw are taken.
void run_target(const Target& target, const std::string& bytes);

}  // namespace phiz::fuzz
