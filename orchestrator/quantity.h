#pragma once

#include <cstdint>
#include <string>

namespace phiz {

/// "1500000", "800k", "4G", "1.5GiB" -> bytes; k, M, G, T are powers of 1024. Throws UsageError that names
/// `label` ("--max-size").
std::uint64_t parse_bytes(const std::string& text, const std::string& label);

/// "90" or "90s", "15m", "12h", "30d" -> seconds. Throws UsageError that names `label`.
double parse_duration(const std::string& text, const std::string& label);

/// "312 B", "4.1 kB", "2.3 MB", "1.2 GB": powers of 1000.
std::string format_bytes(std::uint64_t bytes);

}  // namespace phiz
