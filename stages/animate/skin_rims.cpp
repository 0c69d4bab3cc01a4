#include "stages/animate/skin_rims.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace phiz {
namespace {

constexpr int kPasses = 12;

Eigen::Vector3f at(const std::vector<Point4>& points, int i) {
  return {points[i].x, points[i].y, points[i].z};
}

void shift(Point4& point, float amount, const Eigen::Vector3f& way) {
  point.x += amount * way.x();
  point.y += amount * way.y();
  point.z += amount * way.z();
}

}  // namespace

/// Calls act(contact, index of the inner vertex, is_upper) for every inner vertex of both sides; depth is
/// minus the height.
template <class Act>
void SkinRims::for_contacts(const Rim& rim, const std::vector<Point4>& positions, const Act& act) const {
  const Eigen::Vector3f along =
      (at(positions, rim.upper.back()) - at(positions, rim.upper.front())).normalized();
  const Eigen::Vector3f up = (Eigen::Vector3f::UnitY() - along.y() * along).normalized();
  for (const bool is_upper : {true, false}) {
    const std::vector<int>&mine = is_upper ? rim.upper : rim.lower, &other = is_upper ? rim.lower : rim.upper;
    const Eigen::Vector3f out = is_upper ? up : Eigen::Vector3f(-up);
    for (std::size_t i = 1; i + 1 < mine.size(); ++i) {
      const Eigen::Vector3f p = at(positions, mine[i]);
      const float t = along.dot(p);
      std::size_t k = 0;
      while (k + 2 < other.size() && along.dot(at(positions, other[k + 1])) < t) ++k;
      const Eigen::Vector3f a = at(positions, other[k]), b = at(positions, other[k + 1]);
      const float length = along.dot(b - a);
      const float share = std::clamp(length > 1e-3f ? along.dot(p - a) / length : 0.5f, 0.0f, 1.0f);
      const float height = out.dot(p - (a + share * (b - a)));
      act(Contact{mine[i], other[k], other[k + 1], share, -height, out.x(), out.y(), out.z()}, i, is_upper);
    }
  }
}

SkinRims::SkinRims(const FaceLayout& layout, const std::vector<Point4>& rest) {
  for (const FaceLayout::Rim& rim : layout.rims()) {
    Rim own{rim.upper, rim.lower, std::vector<float>(rim.upper.size(), 0.0f),
            std::vector<float>(rim.lower.size(), 0.0f)};
    for_contacts(own, rest, [&](const Contact& contact, std::size_t i, bool is_upper) {
      (is_upper ? own.upper_least : own.lower_least)[i] = std::min(-contact.depth, 0.0f);
    });
    rims_.push_back(std::move(own));
    for (const std::vector<int>* side : {&rim.upper, &rim.lower})
      vertices_.insert(vertices_.end(), side->begin(), side->end());
  }
  std::sort(vertices_.begin(), vertices_.end());
  vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
}

void SkinRims::add_gradient(const std::vector<Point4>& positions, float stiffness,
                            std::vector<Point4>& gradient) const {
  for (const Rim& rim : rims_) {
    for_contacts(rim, positions, [&](const Contact& c, std::size_t i, bool is_upper) {
      const float depth = c.depth + (is_upper ? rim.upper_least : rim.lower_least)[i];
      if (!(depth > 0)) return;
      const Eigen::Vector3f out(c.nx, c.ny, c.nz);
      shift(gradient[c.vertex], -stiffness * depth, out);
      shift(gradient[c.from], stiffness * depth * (1 - c.share), out);
      shift(gradient[c.to], stiffness * depth * c.share, out);
    });
  }
}

void SkinRims::part(std::vector<Point4>& positions) const {
  for (int pass = 0; pass < kPasses; ++pass) {
    bool is_crossed = false;
    for (const Rim& rim : rims_) {
      for_contacts(rim, positions, [&](const Contact& c, std::size_t i, bool is_upper) {
        const float depth = c.depth + (is_upper ? rim.upper_least : rim.lower_least)[i];
        if (!(depth > 0)) return;
        is_crossed = true;
        const Eigen::Vector3f out(c.nx, c.ny, c.nz);
        const float scale = depth / (1 + (1 - c.share) * (1 - c.share) + c.share * c.share);
        shift(positions[c.vertex], scale, out);
        shift(positions[c.from], -scale * (1 - c.share), out);
        shift(positions[c.to], -scale * c.share, out);
      });
    }
    if (!is_crossed) return;
  }
}

double SkinRims::deepest(const std::vector<Point4>& positions) const {
  double deepest = 0;
  for (const Rim& rim : rims_) {
    for_contacts(rim, positions, [&](const Contact& c, std::size_t i, bool is_upper) {
      deepest =
          std::max(deepest, static_cast<double>(c.depth + (is_upper ? rim.upper_least : rim.lower_least)[i]));
    });
  }
  return deepest;
}

}  // namespace phiz
