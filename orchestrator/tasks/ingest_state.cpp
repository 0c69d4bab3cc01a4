#include "orchestrator/tasks/ingest_state.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace phiz {
namespace {

constexpr std::uint64_t kTag = 0x3174736e67697a70;  // changes whenever the layout does
constexpr std::size_t kUnitBytes = 16;

struct Header {
  std::uint64_t tag = kTag;
  std::uint64_t points = 0, normals = 0, colours = 0, confidences = 0;
  std::array<double, 16> scan_from_head{};
  double head_scale = 1, spacing_mm = 0;
  std::array<std::uint64_t, 7> counts{};
  std::array<double, 8> numbers{};
  std::array<char, kUnitBytes> unit{};
};
static_assert(std::is_trivially_copyable_v<Header>);

/// The summary's counts and numbers in one order, to be read or written.
template <class Summary, class Header>
void exchange(Summary& summary, Header& header, const auto& copy) {
  auto& counts = header.counts;
  copy(summary.points_read, counts[0]), copy(summary.points_sampled, counts[1]),
      copy(summary.points_kept, counts[2]);
  copy(summary.removed_non_finite, counts[3]), copy(summary.removed_outliers, counts[4]);
  copy(summary.removed_below_neck, counts[5]), copy(summary.removed_far, counts[6]);
  auto& numbers = header.numbers;
  copy(summary.mm_per_unit, numbers[0]), copy(summary.head_scale, numbers[1]),
      copy(summary.pose_score, numbers[2]);
  copy(summary.pose_mismatch, numbers[3]), copy(summary.turned_deg, numbers[4]),
      copy(summary.coverage, numbers[5]);
  copy(summary.noise_mm, numbers[6]), copy(summary.density_per_mm2, numbers[7]);
}

template <class Row>
void append(std::string& bytes, const std::vector<Row>& rows) {
  bytes.append(reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(Row));
}

/// False if the bytes do not hold so many.
template <class Row>
bool take(std::string_view& bytes, std::uint64_t count, std::vector<Row>& rows) {
  if (count > bytes.size() / sizeof(Row)) return false;
  rows.resize(count);
  if (count > 0) std::memcpy(static_cast<void*>(rows.data()), bytes.data(), count * sizeof(Row));
  bytes.remove_prefix(count * sizeof(Row));
  return true;
}

bool is_none_or(std::uint64_t rows, std::uint64_t points) {
  return rows == 0 || rows == points;
}

}  // namespace

std::string encode_ingest_state(const IngestState& state) {
  Header header;
  header.points = state.cloud.positions.size();
  header.normals = state.cloud.normals.size();
  header.colours = state.cloud.colours.size();
  header.confidences = state.cloud.confidences.size();
  Eigen::Map<Eigen::Matrix4d>(header.scan_from_head.data()) = state.scan_from_head;
  header.head_scale = state.head_scale;
  header.spacing_mm = state.spacing_mm;
  exchange(state.summary, header, [](const auto& from, auto& to) { to = from; });
  state.summary.unit.copy(header.unit.data(), kUnitBytes - 1);
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
  append(bytes, state.cloud.positions);
  append(bytes, state.cloud.normals);
  append(bytes, state.cloud.colours);
  append(bytes, state.cloud.confidences);
  return bytes;
}

std::optional<IngestState> decode_ingest_state(std::string_view bytes) {
  Header header;
  if (bytes.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof header);
  bytes.remove_prefix(sizeof header);
  const bool is_ours = header.tag == kTag && is_none_or(header.normals, header.points) &&
                       is_none_or(header.colours, header.points) &&
                       is_none_or(header.confidences, header.points) && header.unit.back() == '\0';
  IngestState state;
  if (!is_ours || !take(bytes, header.points, state.cloud.positions) ||
      !take(bytes, header.normals, state.cloud.normals) ||
      !take(bytes, header.colours, state.cloud.colours) ||
      !take(bytes, header.confidences, state.cloud.confidences) || !bytes.empty()) {
    return std::nullopt;
  }
  state.scan_from_head = Eigen::Map<const Eigen::Matrix4d>(header.scan_from_head.data());
  state.head_scale = header.head_scale;
  state.spacing_mm = static_cast<float>(header.spacing_mm);
  exchange(state.summary, header, [](auto& to, const auto& from) { to = from; });
  state.summary.unit = header.unit.data();
  return state;
}

}  // namespace phiz
