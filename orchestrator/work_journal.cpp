#include "orchestrator/work_journal.h"

#include <cstring>

#include "store/checkpoint.h"

namespace phiz {

Digest WorkJournal::key(const std::string& piece) const {
  return compute_digest("phiz work 1\n" + std::to_string(work_.size()) + "\n" + work_ + "\n" + piece);
}

std::optional<std::string> WorkJournal::find(const std::string& piece) {
  const Digest name = key(piece);
  auto bytes = Checkpoint(store_, name).load();
  if (bytes) used_.insert(name);
  return bytes;
}

void WorkJournal::keep(const std::string& piece, std::string_view bytes) {
  const Digest name = key(piece);
  Checkpoint(store_, name).save(std::as_bytes(std::span(bytes)));
  used_.insert(name);
}

void WorkJournal::forget() {
  for (const Digest& name : used_) Checkpoint(store_, name).remove();
  used_.clear();
}

std::optional<std::vector<double>> JournalSteps::find(const std::string& step) {
  const auto bytes = journal_.find(piece_ + "\n" + step);
  if (!bytes || bytes->size() % sizeof(double) != 0) return std::nullopt;
  std::vector<double> numbers(bytes->size() / sizeof(double));
  if (!numbers.empty()) std::memcpy(numbers.data(), bytes->data(), bytes->size());
  return numbers;
}

void JournalSteps::keep(const std::string& step, std::span<const double> numbers) {
  journal_.keep(piece_ + "\n" + step, {reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()});
}

}  // namespace phiz
