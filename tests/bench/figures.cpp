#include "tests/bench/figures.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <thread>

namespace phiz::bench {
namespace {

using nlohmann::ordered_json;

/// Four significant digits, whole numbers as such.
std::string format_value(double value) {
  if (!std::isfinite(value)) return "-";
  if (value == std::round(value) && std::abs(value) < 1e9) return fmt::format("{:.0f}", value);
  return fmt::format("{:.4g}", value);
}

std::string find_line(const std::string& file, const std::string& key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(key)) continue;
    const std::size_t colon = line.find(':');
    const std::size_t begin = line.find_first_not_of(" \t", colon + 1);
    return begin == std::string::npos ? "" : line.substr(begin);
  }
  return "unknown";
}

std::string describe_machine() {
  utsname system{};
  ::uname(&system);
  return fmt::format("{}, {} threads, {}, {} {}", find_line("/proc/cpuinfo", "model name"),
                     std::thread::hardware_concurrency(), find_line("/proc/meminfo", "MemTotal"),
                     system.sysname, system.machine);
}

}  // namespace

bool Bar::holds(double value) const {
  if (kind == Kind::kNone) return true;
  return kind == Kind::kAtMost ? value <= limit : value >= limit;
}

std::string Bar::text() const {
  if (kind == Kind::kNone) return "-";
  return (kind == Kind::kAtMost ? "<= " : ">= ") + format_value(limit);
}

Bar at_most(double limit) {
  return {Bar::Kind::kAtMost, limit};
}

Bar at_least(double limit) {
  return {Bar::Kind::kAtLeast, limit};
}

void Board::write(const Figure& figure, bool is_ok, const std::string& reason) {
  ++figure_count_;
  short_count_ += is_ok ? 0 : 1;
  if (is_json_) {
    ordered_json object = {{"type", "figure"}, {"area", area_}, {"what", figure.what}};
    object["value"] = std::isfinite(figure.value) ? ordered_json(figure.value) : ordered_json(nullptr);
    object["unit"] = figure.unit;
    if (figure.bar.kind != Bar::Kind::kNone) object["bar"] = figure.bar.text();
    object["ok"] = is_ok;
    if (!reason.empty()) object["reason"] = reason;
    out_ << object.dump() << std::endl;
    return;
  }
  out_ << area_ << " | " << figure.what << " | " << format_value(figure.value) << " | " << figure.unit
       << " | " << figure.bar.text() << " | " << (is_ok ? "ok" : "SHORT")
       << (reason.empty() ? "" : " (" + reason + ")") << std::endl;
}

void Board::add(const Figure& figure) {
  write(figure, figure.bar.holds(figure.value), {});
}

void Board::add_missing(const std::string& what, const Bar& bar, const std::string& reason) {
  write({what, std::numeric_limits<double>::quiet_NaN(), "", bar}, false, reason);
}

void Board::note(const std::string& line) {
  if (is_json_) {
    out_ << ordered_json{{"type", "note"}, {"area", area_}, {"text", line}}.dump() << std::endl;
  } else {
    out_ << "# " << line << std::endl;
  }
}

int Board::finish() {
  const int code = short_count_ > 0 ? 1 : 0;
  if (is_json_) {
    out_ << ordered_json{{"type", "exit"},
                         {"area", area_},
                         {"figures", figure_count_},
                         {"short", short_count_},
                         {"code", code}}
                .dump()
         << std::endl;
  } else {
    out_ << "# " << area_ << ": " << figure_count_ << " figures, " << short_count_ << " short" << std::endl;
  }
  return code;
}

void describe_run(const std::string& area, const std::string& data_folder, bool is_json, std::ostream& out) {
  const char* commit = std::getenv("PHIZ_COMMIT");
  const std::string compiler = std::string("g++ ") + __VERSION__ + " " + PHIZ_BENCH_FLAGS;
  const std::string data = data_folder.empty() ? "none" : data_folder;
  if (is_json) {
    out << ordered_json{{"type", "run"},        {"area", area}, {"machine", describe_machine()},
                        {"compiler", compiler}, {"data", data}, {"commit", commit ? commit : "unknown"}}
               .dump()
        << std::endl;
    return;
  }
  out << "# machine: " << describe_machine() << "\n# compiler: " << compiler << "\n# data: " << data
      << "\n# commit: " << (commit ? commit : "unknown") << std::endl;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto rank =
      std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank), values.end());
  return values[rank];
}

double median(std::vector<double> values) {
  return quantile(std::move(values), 0.5);
}

double mean(const std::vector<double>& values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace phiz::bench
