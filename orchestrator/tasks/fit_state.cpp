#include "orchestrator/tasks/fit_state.h"

#include <array>
#include <cstring>

namespace phiz {
namespace {

constexpr std::uint64_t kTag = 0x31746966707a6970;  // changes whenever the layout does

struct Header {
  std::uint64_t tag = kTag;
  std::int32_t round = 0, iteration = 0;
  std::uint64_t positions = 0, energies = 0;
};

}  // namespace

std::string encode_fit_state(const GlobalFitState& state) {
  const Header header{kTag, state.round, state.iteration, state.positions.size(), state.energies.size()};
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
  for (const Eigen::Vector3d& position : state.positions) {
    bytes.append(reinterpret_cast<const char*>(position.data()), 3 * sizeof(double));
  }
  bytes.append(reinterpret_cast<const char*>(state.energies.data()), state.energies.size() * sizeof(double));
  return bytes;
}

std::optional<GlobalFitState> decode_fit_state(std::string_view bytes, std::size_t vertex_count) {
  Header header;
  if (bytes.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof header);
  bytes.remove_prefix(sizeof header);
  const std::size_t position_bytes = 3 * sizeof(double) * vertex_count;
  if (header.tag != kTag || header.positions != vertex_count || header.round < 0 || header.iteration < 0 ||
      bytes.size() < position_bytes || (bytes.size() - position_bytes) / sizeof(double) != header.energies ||
      (bytes.size() - position_bytes) % sizeof(double) != 0) {
    return std::nullopt;
  }
  GlobalFitState state{header.round, header.iteration, ControlPositions(vertex_count),
                       std::vector<double>(header.energies)};
  for (std::size_t i = 0; i < vertex_count; ++i) {
    std::memcpy(state.positions[i].data(), bytes.data() + 3 * sizeof(double) * i, 3 * sizeof(double));
  }
  if (!state.energies.empty()) {
    std::memcpy(state.energies.data(), bytes.data() + position_bytes, state.energies.size() * sizeof(double));
  }
  return state;
}

}  // namespace phiz
