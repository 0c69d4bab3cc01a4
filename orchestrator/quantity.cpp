#include "orchestrator/quantity.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "orchestrator/error.h"

namespace phiz {
namespace {

struct Quantity {
  double number = 0;
  std::string unit;
};

Quantity split(const std::string& text, const std::string& label, const std::string& example) {
  Quantity quantity;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, quantity.number);
  if (error != std::errc() || !std::isfinite(quantity.number) || quantity.number < 0) {
    throw UsageError(label + " " + text + " is no quantity", "for example " + label + " " + example);
  }
  quantity.unit = std::string(rest, end);
  return quantity;
}

}  // namespace

std::uint64_t parse_bytes(const std::string& text, const std::string& label) {
  const Quantity quantity = split(text, label, "4G");
  std::string unit = quantity.unit;
  if (unit.size() > 1 && unit.ends_with("iB")) unit.resize(unit.size() - 2);
  if (unit.size() > 1 && unit.ends_with("B")) unit.resize(unit.size() - 1);
  double factor = 1;
  const std::string_view units = "kMGT";
  if (!unit.empty() && unit != "B") {
    const std::size_t power = units.find(unit == "K" ? "k" : unit);
    if (unit.size() != 1 || power == std::string_view::npos) {
      throw UsageError(label + " " + text + ": unknown unit '" + quantity.unit + "'", "use k, M, G or T");
    }
    for (std::size_t i = 0; i <= power; ++i) factor *= 1024;
  }
  if (quantity.number * factor > 9e18) throw UsageError(label + " " + text + " is too much");
  return static_cast<std::uint64_t>(quantity.number * factor);
}

double parse_duration(const std::string& text, const std::string& label) {
  const Quantity quantity = split(text, label, "30d");
  if (quantity.unit.empty() || quantity.unit == "s") return quantity.number;
  if (quantity.unit == "m") return 60 * quantity.number;
  if (quantity.unit == "h") return 3600 * quantity.number;
  if (quantity.unit == "d") return 86400 * quantity.number;
  throw UsageError(label + " " + text + ": unknown unit '" + quantity.unit + "'", "use s, m, h or d");
}

std::string format_bytes(std::uint64_t bytes) {
  const auto value = static_cast<double>(bytes);
  if (bytes < 10'000) return fmt::format("{} B", bytes);
  if (bytes < 10'000'000) return fmt::format("{:.1f} kB", value / 1e3);
  if (bytes < 10'000'000'000) return fmt::format("{:.1f} MB", value / 1e6);
  return fmt::format("{:.1f} GB", value / 1e9);
}

}  // namespace phiz
