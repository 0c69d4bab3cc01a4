#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "formats/draco_streams.h"
#include "formats/level_topology.h"
#include "formats/residual_coder.h"
#include "stages/subdivide/quantise.h"
#include "stages/subdivide/subdivide.h"
#include "tests/bench/ship.h"

namespace phiz::bench {
namespace {

constexpr double kToleranceMm = 0.02, kCoarseToleranceMm = 0.05;

Positions control_of(const HeadAsset& head) {
  Positions control;
  for (const Eigen::Vector3f& p : head.positions) control.push_back(p.cast<double>());
  return control;
}

TriangleMesh mesh_of(const Positions& positions, const std::vector<Eigen::Vector3i>& triangles) {
  TriangleMesh mesh;
  mesh.positions = to_float(positions);
  mesh.triangles = triangles;
  return mesh;
}

/// The same mesh in Draco at its smallest, to the largest step whose vertices stay within the distance.
std::size_t draco_bytes(const TriangleMesh& mesh, double distance_mm) {
  return encode_surface(mesh, 2 * distance_mm / std::sqrt(3.0)).bytes.size();
}

double entropy_bits(const std::vector<std::int32_t>& numbers) {
  std::map<std::int32_t, double> counts;
  for (const std::int32_t number : numbers) ++counts[number];
  double bits = 0;
  for (const auto& [number, count] : counts)
    bits -= count * std::log2(count / static_cast<double>(numbers.size()));
  return bits;
}

HeadAsset read(const std::string& bytes) {
  std::istringstream in(bytes);
  return read_head_asset(in);
}

/// Bytes of each level's stream beside the entropy of its numbers.
struct LevelBits {
  std::vector<double> coded, entropies, counts;
};

void add_level_bits(const std::string& bytes, LevelBits& bits) {
  const HeadAsset head = read(bytes);
  for (const HeadAssetPart& part : list_head_asset_parts(bytes)) {
    if (!part.name.starts_with("level ")) continue;
    const std::size_t level = std::stoul(part.name.substr(6));
    const std::vector<float>& values = head.displacements_mm[level];
    const std::size_t first = level == 0 ? 0 : head.displacements_mm[level - 1].size();
    std::vector<std::int32_t> numbers;
    float step = INFINITY;
    for (const float value : values)
      if (value != 0) step = std::min(step, std::abs(value));
    for (std::size_t i = first; i < values.size(); ++i)
      numbers.push_back(static_cast<std::int32_t>(std::lround(values[i] / step)));
    bits.coded.resize(std::max(bits.coded.size(), level + 1), 0);
    bits.entropies.resize(bits.coded.size(), 0);
    bits.counts.resize(bits.coded.size(), 0);
    bits.coded[level] += 8.0 * static_cast<double>(part.bytes);
    bits.entropies[level] += entropy_bits(numbers);
    bits.counts[level] += static_cast<double>(numbers.size());
  }
}

void report_level_bits(const ShipWorld& ship, const LevelBits& bits) {
  double coded = 0, entropy = 0;
  for (std::size_t level = 0; level < bits.coded.size(); ++level) {
    ship.world.board.add({fmt::format("bits a displacement, level {}; zeroth-order entropy {:.3f}", level,
                                      bits.entropies[level] / bits.counts[level]),
                          bits.coded[level] / bits.counts[level],
                          "bit",
                          {}});
    coded += bits.coded[level];
    entropy += bits.entropies[level];
  }
  ship.world.board.add(
      {"displacements, all levels, over the sum of their entropies", coded / entropy, "", at_most(0.97)});
}

}  // namespace

void measure_sizes(const ShipWorld& ship) {
  Board& board = ship.world.board;
  std::vector<double> smallest, shown, coarse, prefixes, hausdorffs;
  LevelBits bits;
  for (const ShippedSubject& subject : ship.subjects) {
    const SubdivisionHierarchy hierarchy(subject.head.triangles,
                                         static_cast<int>(subject.head.positions.size()), kFinestLevel);
    const Positions given =
        evaluate_surface(hierarchy, control_of(subject.head), subject.head.displacements_mm, kFinestLevel);
    const std::string bytes =
        export_bytes(ship, subject.name, subject.name + "_small.glb", {"--shown-level", "0"});
    const HeadAsset copy = read(bytes);
    const Positions surface =
        evaluate_surface(hierarchy, control_of(copy), copy.displacements_mm, kFinestLevel);
    const double distance = measure_hausdorff(given, surface, hierarchy.triangles(kFinestLevel));
    const std::size_t draco = draco_bytes(mesh_of(given, hierarchy.triangles(kFinestLevel)), distance);
    const std::size_t with_shown = export_bytes(ship, subject.name, subject.name + ".glb", {}).size();
    const std::string third = export_bytes(
        ship, subject.name, subject.name + "_l3.glb",
        {"--shown-level", "0", "--asset-level", "3", "--tolerance", fmt::format("{}", kCoarseToleranceMm)});
    board.note(fmt::format(
        "{}: asset {} bytes ({} with a shown level 2) at {:.4f} mm, Draco {} bytes; level 3 at {} mm {} "
        "bytes",
        subject.name, bytes.size(), with_shown, distance, draco, kCoarseToleranceMm, third.size()));
    smallest.push_back(static_cast<double>(bytes.size()) / static_cast<double>(draco));
    shown.push_back(static_cast<double>(with_shown) / static_cast<double>(draco));
    coarse.push_back(static_cast<double>(third.size()) / 1000);
    hausdorffs.push_back(distance);
    add_level_bits(bytes, bits);
    for (const HeadAssetPart& part : list_head_asset_parts(bytes))
      if (part.name == "level 0")
        prefixes.push_back(100.0 * static_cast<double>(part.end) / static_cast<double>(bytes.size()));
  }
  const auto worst = [](const std::vector<double>& values) {
    return *std::max_element(values.begin(), values.end());
  };
  board.add({"Hausdorff distance of the assets, measured, worst subject", worst(hausdorffs), "mm",
             at_most(kToleranceMm)});
  board.add({"level-4 asset over Draco at the same distance; shown: the control mesh; worst subject",
             worst(smallest), "", at_most(0.25)});
  board.add({"the same, mean of the subjects", mean(smallest), "", {}});
  board.add({"the same with a shown level 2 (the default) beside, worst subject", worst(shown), "", {}});
  report_level_bits(ship, bits);
  board.add({"asset of level 3 at 0.05 mm, no colour, worst subject", worst(coarse), "kB", at_most(40)});
  board.add({"first picture from so much of the file, worst subject", worst(prefixes), "%", at_most(15)});
}

}  // namespace phiz::bench
