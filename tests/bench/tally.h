#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace phiz::bench {

/// Counts of a long run, piece by piece. With a file every piece is written down as it ends, so that the run
/// can be stopped at any instant and continued by the same command: `part,piece,commit,name=value,...` a
/// line. Without one it is held in memory.
class Tally {
 public:
  Tally(std::filesystem::path file, std::string part);

  int pieces() const { return pieces_; }  ///< so far, those of earlier runs included
  int operator[](const std::string& name) const;
  void add(const std::map<std::string, int>& counts);

 private:
  std::filesystem::path file_;
  std::string part_;
  int pieces_ = 0;
  std::map<std::string, int> sums_;
};

}  // namespace phiz::bench
