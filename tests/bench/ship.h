#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/head_asset.h"
#include "tests/bench/areas.h"

namespace phiz::bench {

/// The fitted subjects that ship's figures are about.
struct ShippedSubject {
  std::string name;
  HeadAsset head;  ///< the store's own
};

struct ShipWorld {
  const BenchWorld& world;
  std::filesystem::path store;
  std::vector<ShippedSubject> subjects;
};

/// Bytes of assets against Draco and against entropies, prefixes.
void measure_sizes(const ShipWorld& ship);
/// Decoding and evaluating, natively.
void measure_decoding(const ShipWorld& ship);
/// Morph targets, gltf-validator, other programs, the viewer in Chromium.
void measure_programs(const ShipWorld& ship);
/// Truncations and random corruptions of an asset.
void measure_damage(const ShipWorld& ship);

/// `phiz export` into the scratch folder; the file's bytes.
std::string export_bytes(const ShipWorld& ship, const std::string& subject, const std::string& file,
                         std::vector<std::string> arguments);

}  // namespace phiz::bench
