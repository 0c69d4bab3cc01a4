// The entry that libFuzzer and our own driver call. $PHIZ_FUZZ_TARGET names the reader.

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const phiz::fuzz::Target* const target = [] {
    const char* name = std::getenv("PHIZ_FUZZ_TARGET");
    const auto* found = phiz::fuzz::find_target(name != nullptr ? name : "");
    if (found == nullptr) {
      std::fputs("set PHIZ_FUZZ_TARGET to one of:", stderr);
      for (const auto& each : phiz::fuzz::list_targets())
        std::fprintf(stderr, " %s", std::string(each.name).c_str());
      std::fputs("\n", stderr);
      std::exit(2);
    }
    return found;
  }();
  phiz::fuzz::run_target(*target, std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
