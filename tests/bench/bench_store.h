#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/bench/figures.h"
#include "tests/bench/phiz_runs.h"

namespace phiz::bench {

/// What the figures of the area `store` are measured with. No test scans are needed: heads are synthetic.
struct StoreBench {
  Board& board;
  const ScratchFolder& scratch;
  bool is_long = false;
  std::filesystem::path build_folder;  ///< where the tests lie
  std::filesystem::path record;        ///< long runs are written down there piece by piece; may be empty
};

/// Small scans made by `phiz synth`, fitted in about half a second each.
std::vector<std::filesystem::path> make_small_scans(const StoreBench& bench, int count);

/// digest, size and name of every current output, sorted: what two stores of equal work agree on.
std::string list_outputs(const std::filesystem::path& store);

void measure_many_subjects(const StoreBench& bench);  ///< 10,000 finished ones: fit --list, status
void measure_write_path(const StoreBench& bench);     ///< commit against sha256sum, cp and sync
void measure_overhead(const StoreBench& bench);       ///< tasks that do nothing
void measure_kills(const StoreBench& bench);          ///< kill -9 of four processes on one store
void measure_lost_work(const StoreBench& bench);      ///< kill -9 in the middle of long stages
void measure_sharing(const StoreBench& bench);        ///< eight processes, the same subjects
void measure_collecting(const StoreBench& bench);     ///< gc beside running fits
void measure_rot(const StoreBench& bench);            ///< one flipped bit
void measure_full_disk(const StoreBench& bench);      ///< a small tmpfs
void measure_tests(const StoreBench& bench);          ///< failures at every operation, hostile bytes

}  // namespace phiz::bench
