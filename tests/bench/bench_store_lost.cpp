// What a kill costs: work that is done twice, on a scan of ten million points with all stages and pictures.

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/bench/bench_store.h"

namespace phiz::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPoints = 10'000'000;

/// The points of a small scan over and over, each time with other noise of 0.1 mm. Binary PLY, float x y z.
fs::path write_large_scan(const StoreBench& bench) {
  const fs::path small = make_small_scans(bench, 1).front();
  std::ifstream in(small, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const std::string end = "end_header\n", count = "element vertex ";
  const std::size_t begin = bytes.find(end) + end.size(), at = bytes.find(count) + count.size();
  const std::size_t points = std::stoul(bytes.substr(at));
  const std::size_t row = (bytes.size() - begin) / points;
  const auto* first = bytes.data() + begin;
  std::mt19937_64 random(1);
  std::normal_distribution<float> noise(0, 0.1f);
  std::vector<float> noises(1 << 20);
  for (float& value : noises) value = noise(random);
  std::string large;
  large.reserve(12 * kPoints);
  for (std::size_t i = 0; i < kPoints; ++i) {
    float position[3];
    std::copy_n(first + (i % points) * row, sizeof position, reinterpret_cast<char*>(position));
    for (std::size_t axis = 0; axis < 3; ++axis)
      position[axis] += noises[(3 * i + axis * 7919) % noises.size()];
    large.append(reinterpret_cast<const char*>(position), sizeof position);
  }
  const fs::path file = bench.scratch / "large.ply";
  std::ofstream(file, std::ios::binary)
      << "ply\nformat binary_little_endian 1.0\nelement vertex " << kPoints
      << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
      << large;
  return file;
}

}  // namespace

void measure_lost_work(const StoreBench& bench) {
  const int kills = bench.is_long ? 20 : 4;
  const fs::path scan = write_large_scan(bench);
  const auto fit = [&](const fs::path& store, std::optional<double> kill_after_s) {
    test::ProgramOptions options;
    options.kill_after_s = kill_after_s;
    return test::run_program({test::phiz_program().string(), "fit", scan.string(), "--views", "--unwrap",
                              "-q", "-j", "1", "--store", store.string()},
                             options);
  };
  const auto whole = fit(bench.scratch / "large", {});
  const std::string outputs = list_outputs(bench.scratch / "large");
  if (whole.exit_code != 0 || outputs.empty())
    return bench.board.add_missing("work lost by a kill", at_most(2), "phiz fit: " + whole.err);
  std::mt19937_64 random(3);
  double most_s = 0;
  int different = 0;
  for (int i = 0; i < kills; ++i) {
    const fs::path store = bench.scratch / fmt::format("lost{}", i);
    const auto killed = fit(store, whole.seconds * static_cast<double>(random() % 10'000) / 10'000);
    const auto again = fit(store, {});
    most_s = std::max(most_s, killed.processor_seconds + again.processor_seconds - whole.processor_seconds);
    different += again.exit_code != 0 || list_outputs(store) != outputs;
    fs::remove_all(store);
  }
  bench.board.note(fmt::format(
      "{} kills of a fit with pictures and geometry image, 10 million points, one thread", kills));
  bench.board.add({"the whole fit, processor time", whole.processor_seconds, "s", {}});
  bench.board.add(
      {"most work done twice, processor time, start of the program included", most_s, "s", at_most(2)});
  bench.board.add({"final outputs that differ", static_cast<double>(different), "", at_most(0)});
}

}  // namespace phiz::bench
