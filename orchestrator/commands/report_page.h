#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace phiz {

struct StageReport {
  std::string name, status;
  double seconds = 0;
  std::uint64_t peak_memory_bytes = 0;
  std::string key_text;                        ///< parameters and digests of inputs, as hashed
  std::map<std::string, std::string> outputs;  ///< name -> digest
  nlohmann::ordered_json summary;              ///< the stage's own figures; null if it has none
};

struct Residuals {
  std::size_t points = 0;
  double mean_mm = 0, median_mm = 0, p95_mm = 0, p99_mm = 0;
};

struct SubjectReport {
  std::string name, verdict, scan_path, scan_digest;
  std::vector<StageReport> stages;
  std::map<std::string, std::string> pictures;  ///< file name -> bytes of a .png
  Residuals residuals;                          ///< of the scan's points to the finished surface
  std::map<std::string, Residuals> regions;     ///< by region of the generic head; "elsewhere"
  std::vector<double> histogram;                ///< shares of points by tenths of a mm, the last beyond
};

/// One self-contained page: a gallery that sorts by any column, then a chapter a subject. Same input, same
/// bytes.
std::string make_report_page(const std::vector<SubjectReport>& reports);

}  // namespace phiz
