#pragma once

#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace phiz::bench {

/// What a figure has to reach. Without a limit it is printed for comparison only.
struct Bar {
  enum class Kind { kNone, kAtMost, kAtLeast };
  Kind kind = Kind::kNone;
  double limit = 0;

  bool holds(double value) const;  ///< never for a value that is no number
  std::string text() const;        ///< "<= 0.1", ">= 97" or "-"
};

Bar at_most(double limit);
Bar at_least(double limit);

struct Figure {
  std::string what;
  double value = 0;
  std::string unit;
  Bar bar;
};

/// The measured figures of one area, told as they come: `AREA | what | value | unit | bar | ok` or `SHORT`,
/// or a JSON object a line.
class Board {
 public:
  Board(std::string area, bool is_json, std::ostream& out)
      : area_(std::move(area)), is_json_(is_json), out_(out) {}

  void add(const Figure& figure);
  /// A figure that could not be measured: it falls short.
  void add_missing(const std::string& what, const Bar& bar, const std::string& reason);
  void note(const std::string& line);  ///< for people: what the next figures are about

  /// 1 if a figure fell short. With JSON also the closing object.
  int finish();

 private:
  void write(const Figure& figure, bool is_ok, const std::string& reason);

  std::string area_;
  bool is_json_;
  std::ostream& out_;
  int short_count_ = 0, figure_count_ = 0;
};

/// Machine, compiler, data folder and commit.
void describe_run(const std::string& area, const std::string& data_folder, bool is_json, std::ostream& out);

double median(std::vector<double> values);                  ///< NaN of none
double mean(const std::vector<double>& values);             ///< NaN of none
double quantile(std::vector<double> values, double share);  ///< nearest rank; NaN of none

}  // namespace phiz::bench
