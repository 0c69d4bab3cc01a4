#pragma once

#include "tests/bench/figures.h"
#include "tests/bench/fitted.h"
#include "tests/bench/subjects.h"

namespace phiz::bench {

/// What an area's figures are measured on.
struct BenchWorld {
  const BenchData& data;
  const GenericHead& head;
  const ScratchFolder& scratch;
  Board& board;
  bool is_long = false;  ///< all the rotations and kills; otherwise a sample whose size is printed
};

constexpr int kFinestLevel = 4;

/// Cold and cached runs, memory, kills, digests. Run it first: a program's peak memory is never reported
/// lower than that of the process that started it.
void measure_runs(const BenchWorld& world);

/// Fits every scan in one command and reports how many were fitted.
FitRun fit_everything(const BenchWorld& world, const std::filesystem::path& store);

/// Scans turned, in other units, moved: fitted all the same?
void measure_turned(const BenchWorld& world, const std::filesystem::path& store, const FitRun& everything);

/// Ingest's shares, distances stage by stage, true skin, correspondence.
void measure_accuracy(const BenchWorld& world, const std::filesystem::path& store, const FitRun& everything);

/// Three silhouettes and their counts.
void measure_silhouettes(const BenchWorld& world);

}  // namespace phiz::bench
