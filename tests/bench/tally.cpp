#include "tests/bench/tally.h"

#include <cstdlib>
#include <fstream>
#include <sstream>

namespace phiz::bench {

Tally::Tally(std::filesystem::path file, std::string part) : file_(std::move(file)), part_(std::move(part)) {
  std::ifstream in(file_);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(part_ + ",")) continue;
    ++pieces_;
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) {
      const std::size_t equals = field.find('=');
      if (equals != std::string::npos)
        sums_[field.substr(0, equals)] += std::atoi(field.c_str() + equals + 1);
    }
  }
}

int Tally::operator[](const std::string& name) const {
  const auto found = sums_.find(name);
  return found == sums_.end() ? 0 : found->second;
}

void Tally::add(const std::map<std::string, int>& counts) {
  for (const auto& [name, count] : counts) sums_[name] += count;
  if (!file_.empty()) {
    const char* commit = std::getenv("PHIZ_COMMIT");
    std::ofstream out(file_, std::ios::app);
    out << part_ << ',' << pieces_ << ',' << (commit != nullptr ? commit : "unknown");
    for (const auto& [name, count] : counts) out << ',' << name << '=' << count;
    out << '\n';
  }
  ++pieces_;
}

}  // namespace phiz::bench
