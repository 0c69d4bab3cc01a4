#include "tests/bench/bench_main.h"

#include <cstdlib>
#include <filesystem>
#include <iostream>

namespace phiz::bench {

namespace {

/// The generic head as it is now, $PHIZ_TEMPLATE or the tree's, for this process and every phiz it runs: one
/// head all through, whatever happens to the tree meanwhile.
std::filesystem::path keep_generic_head(const ScratchFolder& scratch) {
  const char* variable = std::getenv("PHIZ_TEMPLATE");
  const std::filesystem::path source = variable && *variable ? std::filesystem::path(variable)
                                                             : std::filesystem::path(PHIZ_SOURCE_FOLDER) /
                                                                   "samples" / "generic_head" / "head.obj";
  const std::filesystem::path kept = scratch / "generic_head.obj";
  for (const char* extension : {".obj", ".json"}) {
    std::filesystem::copy_file(std::filesystem::path(source).replace_extension(extension),
                               std::filesystem::path(kept).replace_extension(extension));
  }
  ::setenv("PHIZ_TEMPLATE", kept.c_str(), 1);
  return kept;
}

}  // namespace

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
    const ScratchFolder scratch;
    const GenericHead head = load_generic_head(keep_generic_head(scratch), kFinestLevel);
    measure({*data, head, scratch, board, is_long});
    return board.finish();
  } catch (const std::exception& error) {
    std::cerr << "error: bench " << area << ": " << error.what() << "\n";
    return 1;
  }
}

}  // namespace phiz::bench
