#include "tests/lint/layers.h"

#include <algorithm>
#include <map>
#include <set>

namespace phiz::lint {
namespace {

struct Include {
  std::string path;
  bool is_quoted = false;
};

Include parse_include(const std::string& line) {
  const std::size_t hash = line.find_first_not_of(" \t");
  if (hash == std::string::npos || line.compare(hash, 1, "#") != 0) return {};
  const std::size_t word = line.find_first_not_of(" \t", hash + 1);
  if (word == std::string::npos || line.compare(word, 7, "include") != 0) return {};
  const std::size_t open = line.find_first_of("\"<", word);
  if (open == std::string::npos) return {};
  const std::size_t close = line.find_first_of("\">", open + 1);
  return {line.substr(open + 1, close - open - 1), line[open] == '"'};
}

std::string first_folder(const std::string& path) {
  return path.substr(0, path.find('/'));
}

/// "fit" of "stages/fit/fit.h"; empty if the path is not below stages.
std::string stage_of(const std::string& path) {
  if (!path.starts_with("stages/")) return {};
  const std::size_t end = path.find('/', 7);
  return end == std::string::npos ? std::string() : path.substr(7, end - 7);
}

bool is_heavy(const std::string& path) {
  for (const char* prefix : {"openvdb/", "OpenEXR/", "Imf", "Imath", "draco/", "CGAL/", "GL/", "nanoflann"}) {
    if (path.starts_with(prefix)) return true;
  }
  return false;
}

/// What a file of `layer` must not include of ours, in words; empty if it may.
std::string judge(const std::string& path, const std::string& included) {
  const std::string layer = first_folder(path), other = first_folder(included);
  if (layer == "formats" && other != "formats") return "formats include nobody";
  if (layer == "store" && other != "store") return "store includes nobody";
  if (other == "tests" && layer != "tests") return "only tests include tests";
  if (layer == "stages") {
    if (other != "formats" && other != "stages") return "stages include formats and stages";
    const std::string stage = stage_of(path), used = stage_of(included);
    const bool is_open = used.empty() || used == stage || used == "geometry";
    if (!is_open && stage == "geometry") return "geometry is the ground floor of stages";
    if (!is_open && included != "stages/" + used + "/" + used + ".h")
      return "only the public header of another stage";
  }
  return {};
}

/// A stage that reaches itself through what it includes; empty if there is none.
std::string find_circle(const std::map<std::string, std::set<std::string>>& uses) {
  for (const auto& [start, direct] : uses) {
    std::set<std::string> reached(direct.begin(), direct.end());
    for (bool grows = true; grows;) {
      const std::size_t before = reached.size();
      for (const std::string& stage : std::set<std::string>(reached)) {
        const auto next = uses.find(stage);
        if (next != uses.end()) reached.insert(next->second.begin(), next->second.end());
      }
      grows = reached.size() > before;
    }
    if (reached.contains(start)) return start;
  }
  return {};
}

}  // namespace

std::vector<std::string> find_layer_violations(const std::vector<SourceFile>& files) {
  const std::set<std::string> ours = {"formats", "store", "stages", "orchestrator", "tests"};
  std::vector<std::string> violations;
  std::map<std::string, std::set<std::string>> uses;  // stage -> stages it includes
  for (const SourceFile& file : files) {
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      const Include include = parse_include(file.lines[i]);
      if (include.path.empty()) continue;
      const std::string place = file.path + ":" + std::to_string(i + 1) + ": ";
      if (is_heavy(include.path) && file.path.ends_with(".h")) {
        violations.push_back(place + include.path + " belongs into a .cpp file");
      }
      if (!include.is_quoted) continue;
      if (!ours.contains(first_folder(include.path))) {
        violations.push_back(place + include.path + " is not a path from the root");
        continue;
      }
      const std::string verdict = judge(file.path, include.path);
      if (!verdict.empty()) violations.push_back(place + include.path + ": " + verdict);
      const std::string stage = stage_of(file.path), used = stage_of(include.path);
      if (!stage.empty() && !used.empty() && stage != used) uses[stage].insert(used);
    }
  }
  const std::string circle = find_circle(uses);
  if (!circle.empty()) violations.push_back("stages/" + circle + ": stages include each other in a circle");
  return violations;
}

}  // namespace phiz::lint
