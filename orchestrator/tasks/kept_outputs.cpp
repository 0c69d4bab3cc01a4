#include "orchestrator/tasks/kept_outputs.h"

#include <cstdint>
#include <cstring>
#include <string_view>

namespace phiz {
namespace {

constexpr std::string_view kTag = "phiz outputs 1\n";
constexpr double kWorthSaving_s = 1;

void append_sized(std::string& bytes, const std::string& part) {
  const std::uint64_t size = part.size();
  bytes.append(reinterpret_cast<const char*>(&size), sizeof size).append(part);
}

/// False if the bytes end early.
bool take_sized(std::string_view& bytes, std::string& part) {
  std::uint64_t size = 0;
  if (bytes.size() < sizeof size) return false;
  std::memcpy(&size, bytes.data(), sizeof size);
  bytes.remove_prefix(sizeof size);
  if (size > bytes.size()) return false;
  part = bytes.substr(0, size);
  bytes.remove_prefix(size);
  return true;
}

}  // namespace

KeptOutputs::KeptOutputs(TaskContext& context) : context_(context) {
  const auto saved = context.load_checkpoint();
  if (!saved || !saved->starts_with(kTag)) return;
  std::string_view bytes = std::string_view(*saved).substr(kTag.size());
  for (std::string name, output; take_sized(bytes, name) && take_sized(bytes, output);)
    outputs_[name] = output;
}

bool KeptOutputs::write_kept(const std::string& output) {
  const auto kept = outputs_.find(output);
  if (kept == outputs_.end()) return false;
  context_.write_output(output, kept->second);
  return true;
}

void KeptOutputs::write(const std::string& output, std::string bytes) {
  context_.write_output(output, bytes);
  outputs_[output] = std::move(bytes);
  if (!context_.checkpoint_due(kWorthSaving_s) && !context_.stop_requested()) return;
  std::string state(kTag);
  for (const auto& [name, made] : outputs_) {
    append_sized(state, name);
    append_sized(state, made);
  }
  context_.save_checkpoint(std::as_bytes(std::span(state)));
}

}  // namespace phiz
