#include "orchestrator/tasks/fit_state.h"

#include <cstring>

namespace phiz {
namespace {

constexpr std::uint64_t kTag = 0x33746966707a6970;  // changes whenever the layout does

struct Header {
  std::uint64_t tag = kTag;
  std::int32_t round = 0, iteration = 0;
  std::uint64_t eyes_shut = 0;
  std::uint64_t vertices = 0, energies = 0;
};

void append(std::string& bytes, const ControlPositions& positions) {
  for (const Eigen::Vector3d& position : positions) {
    bytes.append(reinterpret_cast<const char*>(position.data()), 3 * sizeof(double));
  }
}

ControlPositions take_positions(std::string_view& bytes, std::size_t count) {
  ControlPositions positions(count);
  for (Eigen::Vector3d& position : positions) {
    std::memcpy(position.data(), bytes.data(), 3 * sizeof(double));
    bytes.remove_prefix(3 * sizeof(double));
  }
  return positions;
}

}  // namespace

std::string encode_fit_state(const GlobalFitState& state) {
  const Header header{kTag,
                      state.round,
                      state.iteration,
                      std::uint64_t{state.eyes_shut},
                      state.positions.size(),
                      state.energies.size()};
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
  append(bytes, state.positions);
  append(bytes, state.round_start);
  bytes.append(reinterpret_cast<const char*>(state.energies.data()), state.energies.size() * sizeof(double));
  return bytes;
}

std::optional<GlobalFitState> decode_fit_state(std::string_view bytes, std::size_t vertex_count) {
  Header header;
  if (bytes.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof header);
  bytes.remove_prefix(sizeof header);
  const bool is_ours =
      header.tag == kTag && header.vertices == vertex_count && header.round >= 0 && header.iteration >= 0;
  const std::size_t doubles = bytes.size() / sizeof(double), position_doubles = 2 * 3 * vertex_count;
  if (!is_ours || bytes.size() % sizeof(double) != 0 || doubles < position_doubles ||
      doubles - position_doubles != header.energies) {
    return std::nullopt;
  }
  GlobalFitState state;
  state.round = header.round;
  state.iteration = header.iteration;
  state.eyes_shut = header.eyes_shut != 0;
  state.positions = take_positions(bytes, vertex_count);
  state.round_start = take_positions(bytes, vertex_count);
  state.energies.resize(header.energies);
  if (!state.energies.empty()) std::memcpy(state.energies.data(), bytes.data(), bytes.size());
  return state;
}

}  // namespace phiz
