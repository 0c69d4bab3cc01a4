#include "tests/bench/bench_store.h"

#include <cstdlib>
#include <iostream>

namespace {

int run(int argc, char** argv) {
  using namespace phiz::bench;
  bool is_json = false, is_long = false;
  std::string only, record;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    is_json = is_json || word == "--json";
    is_long = is_long || word == "--long";
    if (word == "--only" && i + 1 < argc) only = argv[++i];
    if (word == "--record" && i + 1 < argc) record = argv[++i];
  }
  describe_run("store", "synthetic", is_json, std::cout);
  Board board("store", is_json, std::cout);
  const ScratchFolder scratch;
  const StoreBench bench{board, scratch, is_long, PHIZ_BUILD_FOLDER, record};
  const std::vector<std::pair<std::string, void (*)(const StoreBench&)>> parts = {
      {"many", measure_many_subjects},
      {"write", measure_write_path},
      {"overhead", measure_overhead},
      {"kills", measure_kills},
      {"lost", measure_lost_work},
      {"sharing", measure_sharing},
      {"gc", measure_collecting},
      {"rot", measure_rot},
      {"full", measure_full_disk},
      {"tests", measure_tests}};
  for (const auto& [name, measure] : parts) {
    if (only.empty() || only == name) measure(bench);
  }
  return board.finish();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "error: bench store: " << error.what() << "\n";
    return 1;
  }
}
