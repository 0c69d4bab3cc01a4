#pragma once

#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "stages/geometry/step_keeper.h"
#include "store/store.h"

namespace phiz {

/// What a long command outside the pipeline (learn, track) has finished, piece by piece, so that the same
/// command continues where it was killed. A piece is a checkpoint of its own in the store, named by the
/// digest of everything it was made from. Pieces that are never asked for again go with the next `store gc`.
class WorkJournal {
 public:
  /// `work` says what is being done and from what: version of the method, digests of inputs, options.
  WorkJournal(const Store& store, std::string work) : store_(store), work_(std::move(work)) {}

  std::optional<std::string> find(const std::string& piece);
  void keep(const std::string& piece, std::string_view bytes);

  /// When the command's output is in place.
  void forget();

 private:
  Digest key(const std::string& piece) const;

  const Store& store_;
  const std::string work_;
  std::set<Digest> used_;
};

/// Steps of one piece of work as pieces of a journal.
class JournalSteps final : public StepKeeper {
 public:
  JournalSteps(WorkJournal& journal, std::string piece) : journal_(journal), piece_(std::move(piece)) {}
  std::optional<std::vector<double>> find(const std::string& step) override;
  void keep(const std::string& step, std::span<const double> numbers) override;

 private:
  WorkJournal& journal_;
  const std::string piece_;
};

}  // namespace phiz
