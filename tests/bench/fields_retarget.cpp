#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/motion.h"
#include "tests/bench/fields.h"

namespace phiz::bench {
namespace {

constexpr int kFrames = 300, kMany = 100, kFew = 10;

/// All of ARKit's names at once, each with its own rhythm, as a face that talks.
Motion make_motion() {
  Motion motion;
  motion.frames_per_second = 60;
  for (const std::string_view name : arkit_names()) motion.names.emplace_back(name);
  for (int i = 0; i < kFrames; ++i) {
    motion.times_s.push_back(i / 60.0);
    for (std::size_t k = 0; k < motion.names.size(); ++k)
      motion.values.push_back(
          static_cast<float>(std::max(0.0, 0.6 * std::sin(0.05 * i * (1 + 0.13 * static_cast<double>(k))))));
  }
  return motion;
}

/// `count` subjects of one store: the fitted scans again under other names, which costs nothing.
std::filesystem::path make_store(const FieldsWorld& world, int count) {
  const std::filesystem::path list = world.bench.scratch / fmt::format("list{}.csv", count);
  std::vector<std::filesystem::path> scans;
  for (const BenchSubject& subject : world.bench.data.subjects) {
    const auto run = world.fits.subjects.find(subject.name);
    if (run != world.fits.subjects.end() && run->second.is_done) scans.push_back(subject.scan);
  }
  std::ofstream out(list);
  out << "scan,subject\n";
  for (int i = 0; i < count; ++i)
    out << std::filesystem::absolute(scans.at(static_cast<std::size_t>(i) % scans.size())).string() << ",s"
        << i << "\n";
  return list;
}

struct RetargetRun {
  double rate = 0, memory_mib = 0;
};

RetargetRun run(const FieldsWorld& world, const std::filesystem::path& motion, int count) {
  std::vector<std::string> arguments = {
      "retarget", "--motion", motion.string(), "--rig", world.rig_path.string(),
      "--level",  "2",        "--json",        "--to"};
  for (int i = 0; i < count; ++i) arguments.push_back(fmt::format("s{}", i));
  const test::ProgramRun done = run_phiz(world.store, arguments);
  if (done.exit_code != 0) throw std::runtime_error("phiz retarget: " + done.out + done.err);
  RetargetRun result;
  std::istringstream lines(done.out);
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json object = nlohmann::json::parse(line);
    if (object["type"] == "retarget_total")
      result.rate = object["subject_frames"].get<double>() / object["seconds"].get<double>();
  }
  result.memory_mib = static_cast<double>(done.peak_memory_bytes) / (1 << 20);
  return result;
}

}  // namespace

void measure_retarget(const FieldsWorld& world) {
  const std::filesystem::path motion = world.bench.scratch / "motion.csv";
  std::ofstream out(motion);
  write_live_link_csv(make_motion(), out);
  out.close();
  const test::ProgramRun fitted = run_phiz(world.store, {"fit", "--list", make_store(world, kMany).string()});
  if (fitted.exit_code != 0) throw std::runtime_error("phiz fit --list: " + fitted.err);
  const RetargetRun few = run(world, motion, kFew), many = run(world, motion, kMany);
  world.bench.board.note(fmt::format(
      "{} frames in a Live Link Face file, level 2, evaluated; heads read from the store", kFrames));
  world.bench.board.add(
      {"retarget, 100 subjects: subject-frames a second", many.rate, "1/s", at_least(2000)});
  world.bench.board.add({"retarget, 10 subjects: peak memory", few.memory_mib, "MiB", {}});
  world.bench.board.add({"retarget, 100 subjects: peak memory over that of 10",
                         many.memory_mib / few.memory_mib, "", at_most(1.1)});
}

}  // namespace phiz::bench
