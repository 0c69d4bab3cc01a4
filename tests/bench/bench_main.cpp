#include "tests/bench/bench_main.h"

#include <iostream>

namespace phiz::bench {

int run_area(const std::string& area, int argc, char** argv,
             const std::function<void(const BenchWorld&)>& measure) {
  bool is_json = false, is_long = false;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--json") {
      is_json = true;
    } else if (word == "--long") {
      is_long = true;
    } else {
      std::cerr << "error: unknown option " << word << "\nhint: --json, --long\n";
      return 2;
    }
  }
  try {
    const std::optional<BenchData> data = find_bench_data();
    describe_run(area, data ? data->folder.string() : "", is_json, std::cout);
    Board board(area, is_json, std::cout);
    if (!data) {
      board.note("no test scans: set PHIZ_DATA to a folder with subjects.json; skipped");
      return board.finish();
    }
    const GenericHead head = load_generic_head(kFinestLevel);
    const ScratchFolder scratch;
    measure({*data, head, scratch, board, is_long});
    return board.finish();
  } catch (const std::exception& error) {
    std::cerr << "error: bench " << area << ": " << error.what() << "\n";
    return 1;
  }
}

}  // namespace phiz::bench
