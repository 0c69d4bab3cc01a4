#include "stages/template/layout.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <istream>
#include <map>
#include <sstream>

#include "formats/error.h"

namespace phiz {
namespace {

constexpr std::size_t kMaxLine = 1 << 16;
constexpr std::size_t kMaxPoints = 100'000;

using Words = std::vector<std::string>;

/// One statement while it is read; `fail` names its line.
struct Statement {
  Words words;
  int line = 0;

  [[noreturn]] void fail(std::string what) const {
    for (char& c : what) {
      if (static_cast<unsigned char>(c) < ' ') c = '?';
    }
    throw FormatError(what + " (line " + std::to_string(line) + ")");
  }
  const std::string& word(std::size_t idx) const {
    if (idx >= words.size()) fail("'" + words[0] + "' lacks a word");
    return words[idx];
  }
  double number(std::size_t idx) const {
    const std::string& text = word(idx);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value) ||
        std::abs(value) > 1e6) {
      fail("'" + text + "' is not a number");
    }
    return value;
  }
  bool is_number(std::size_t idx) const {
    const char first = words[idx][0];
    return (first >= '0' && first <= '9') || first == '-' || first == '.';
  }
  /// A word that files of annotations take as a name.
  const std::string& name(std::size_t idx) const {
    const std::string& text = word(idx);
    const bool good = std::all_of(text.begin(), text.end(), [](unsigned char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
             c == '-' || c == '.';
    });
    if (!good) fail("names have only letters, digits, '_', '-' and '.'");
    return text;
  }
  void expect_size(std::size_t size) const {
    if (words.size() != size)
      fail("'" + words[0] + "' has " + std::to_string(words.size() - 1) + " words, not " +
           std::to_string(size - 1));
  }
};

class Parser {
 public:
  Layout parse(std::istream& in) {
    std::string line;
    int number = 1;
    for (; std::getline(in, line); ++number) {
      Statement statement;
      statement.line = number;
      if (line.size() > kMaxLine) statement.fail("line is too long");
      std::istringstream words(line.substr(0, line.find('#')));
      for (std::string word; words >> word;) statement.words.push_back(word);
      if (!statement.words.empty()) dispatch(statement);
    }
    if (in.bad()) throw FormatError("cannot be read");
    if (layout_.points.empty()) throw FormatError("no points (line " + std::to_string(number) + ")");
    return std::move(layout_);
  }

 private:
  void dispatch(const Statement& s) {
    static const std::map<std::string, void (Parser::*)(const Statement&)> kStatements = {
        {"point", &Parser::add_point},       {"free", &Parser::add_free},
        {"curve", &Parser::add_curve},       {"flow", &Parser::add_curve},
        {"edge", &Parser::add_edge},         {"region", &Parser::add_region},
        {"landmark", &Parser::add_landmark}, {"box", &Parser::add_box},
        {"bind", &Parser::add_binding},      {"constrain", &Parser::add_constraint},
        {"plane", &Parser::add_plane},       {"scale", &Parser::add_scale}};
    const auto found = kStatements.find(s.words[0]);
    if (found == kStatements.end()) s.fail("unknown statement '" + s.words[0] + "'");
    (this->*found->second)(s);
  }

  Eigen::Vector2d half_uv(const Statement& s, std::size_t idx) const {
    const Eigen::Vector2d uv(s.number(idx), s.number(idx + 1));
    if (uv[0] < 0 || uv[0] > 0.5 || uv[1] < 0 || uv[1] > 1) s.fail("(u,v) is not in [0,0.5] x [0,1]");
    return uv;
  }

  int place_point(const Statement& s, const std::string& name, const Eigen::Vector2d& uv) {
    if (layout_.points.size() >= kMaxPoints) s.fail("too many points");
    if (!places_.insert({{uv[0], uv[1]}, s.line}).second) {
      s.fail("a second point in the place of that of line " + std::to_string(places_[{uv[0], uv[1]}]));
    }
    layout_.points.push_back({name, uv, false, s.line});
    return static_cast<int>(layout_.points.size()) - 1;
  }

  void add_point(const Statement& s) {
    s.expect_size(4);
    const int idx = place_point(s, s.word(1), half_uv(s, 2));
    if (!point_idx_.insert({s.word(1), idx}).second) s.fail("point '" + s.word(1) + "' is there already");
  }

  void add_free(const Statement& s) {
    if (s.words.size() == 4) return add_point(s);
    s.expect_size(3);
    place_point(s, "", half_uv(s, 1));
  }

  void add_edge(const Statement& s) {
    s.expect_size(3);
    const int a = find_point(s, s.word(1)), b = find_point(s, s.word(2));
    if (a == b) s.fail("an edge needs two points");
    layout_.edges.push_back({a, b});
  }

  void add_curve(const Statement& s) {
    Layout::Curve curve;
    curve.name = s.word(1);
    curve.line = s.line;
    curve.held = s.words[0] == "curve";
    std::size_t first = 2;
    if (s.word(2) == "closed") curve.closed = true, first = 3;
    for (std::size_t k = first; k < s.words.size(); ++k) {
      std::string name = s.words[k];
      const bool corner = name.back() == '!';
      if (corner) name.pop_back();
      const int point = find_point(s, name);
      if (std::find(curve.points.begin(), curve.points.end(), point) != curve.points.end()) {
        s.fail("point '" + name + "' twice in a curve");
      }
      curve.points.push_back(point);
      curve.corner.push_back(corner);
      if (curve.held) layout_.points[point].held = true;
    }
    if (curve.points.size() < (curve.closed ? 3u : 2u)) s.fail("curve '" + curve.name + "' is too short");
    if (!curve_idx_.insert({curve.name, static_cast<int>(layout_.curves.size())}).second) {
      s.fail("curve '" + curve.name + "' is there already");
    }
    layout_.curves.push_back(std::move(curve));
  }

  int find_point(const Statement& s, const std::string& name) const {
    const auto found = point_idx_.find(name);
    if (found == point_idx_.end()) s.fail("no point '" + name + "'");
    return found->second;
  }

  int find_curve(const Statement& s, const std::string& name) const {
    const auto found = curve_idx_.find(name);
    if (found == curve_idx_.end()) s.fail("no curve '" + name + "'");
    return found->second;
  }

  bool has_region(const std::string& name) const {
    return std::any_of(layout_.regions.begin(), layout_.regions.end(),
                       [&](const Layout::Region& r) { return r.right == name || r.left == name; });
  }

  void add_region(const Statement& s) {
    Layout::Region region;
    region.right = region.left = s.name(1);
    region.line = s.line;
    std::size_t k = 2;
    if (s.word(2) != "at" && s.word(2) != "also") region.left = s.name(k++);
    if (has_region(region.right) || has_region(region.left))
      s.fail("region '" + s.word(1) + "' is there already");
    if (k < s.words.size() && s.words[k] == "at") {
      for (++k; k < s.words.size() && s.is_number(k); k += 2) region.seeds.push_back(half_uv(s, k));
    }
    if (k < s.words.size() && s.words[k] == "within") {
      for (++k; k < s.words.size() && s.words[k] != "also"; ++k) {
        region.walls.push_back(find_curve(s, s.words[k]));
      }
    }
    if (k < s.words.size() && s.words[k] == "also") {
      for (++k; k < s.words.size(); ++k) {
        if (!has_region(s.words[k])) s.fail("no region '" + s.words[k] + "'");
        region.including.push_back(s.words[k]);
      }
    }
    if (k != s.words.size()) s.fail("'" + s.words[k] + "' is not understood");
    if (region.seeds.empty() && region.including.empty()) s.fail("region '" + region.right + "' is empty");
    layout_.regions.push_back(std::move(region));
  }

  void add_landmark(const Statement& s) {
    Layout::Landmark mark;
    mark.right = mark.left = s.name(1);
    mark.line = s.line;
    if (s.words.size() == 5)
      mark.left = s.name(2);
    else
      s.expect_size(4);
    mark.uv = half_uv(s, s.words.size() - 2);
    layout_.landmarks.push_back(mark);
  }

  void add_box(const Statement& s) {
    Layout::Box box;
    box.right = box.left = s.name(1);
    box.line = s.line;
    if (s.words.size() == 5)
      box.left = s.name(2);
    else
      s.expect_size(4);
    box.region = s.word(s.words.size() - 2);
    if (!has_region(box.region)) s.fail("no region '" + box.region + "'");
    box.pad_mm = s.number(s.words.size() - 1);
    layout_.boxes.push_back(box);
  }

  void add_binding(const Statement& s) {
    s.expect_size(3);
    const int a = find_point(s, s.word(1)), b = find_point(s, s.word(2));
    if (a == b) s.fail("a point cannot be bound to itself");
    layout_.bindings.push_back({a, b});
  }

  void add_constraint(const Statement& s) {
    s.expect_size(2);
    const std::string& name = s.word(1);
    const bool is_curve = std::any_of(layout_.curves.begin(), layout_.curves.end(),
                                      [&](const auto& curve) { return curve.name == name; });
    if (!is_curve && !has_region(name)) s.fail("no region and no curve '" + name + "'");
    (is_curve ? layout_.constrained_curves : layout_.constrained_regions).push_back(name);
  }

  void add_plane(const Statement& s) {
    s.expect_size(5);
    Eigen::Vector3d normal(0, s.number(2), s.number(3));
    if (normal.norm() < 1e-6) s.fail("the plane has no normal");
    layout_.planes[s.name(1)] = {normal.normalized(), s.number(4)};
  }

  void add_scale(const Statement& s) {
    s.expect_size(7);
    Layout::Scale scale{s.number(1), {s.number(2), s.number(3), s.number(4)}, s.number(5), s.number(6)};
    if (scale.scale <= 0 || scale.inner_mm < 0 || scale.outer_mm <= scale.inner_mm)
      s.fail("no sensible scale");
    layout_.scales.push_back(scale);
  }

  Layout layout_;
  std::map<std::string, int> point_idx_, curve_idx_;
  std::map<std::pair<double, double>, int> places_;
};

}  // namespace

Layout parse_layout(std::istream& in) {
  return Parser().parse(in);
}

}  // namespace phiz
