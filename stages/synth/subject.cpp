#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/synth/anatomy.h"
#include "stages/synth/random_stream.h"

namespace phiz {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kGrain = 2048;
constexpr int kBumps = 90;
constexpr double kLimit = 2.5, kDrawnIrregularityMm = 0.7;

Vector3d on_midline(Vector3d p) {
  p.x() = 0;
  return p;
}

/// A smooth dent or rise that no slider describes.
struct Irregularity {
  Vector3d centre, direction;
  double radius_mm = 1;
};

std::vector<Irregularity> draw_irregularities(const SubjectBase& base, const SubjectRecipe& recipe) {
  std::vector<Irregularity> bumps;
  if (recipe.irregularity_mm == 0) return bumps;
  RandomStream random({recipe.irregularity_seed, 0x62756d70});
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& p : base.positions) middle += p / static_cast<double>(base.positions.size());
  for (int i = 0; i < kBumps; ++i) {
    Irregularity bump;
    const std::size_t vertex = random.next() % base.positions.size();
    bump.centre = base.positions[vertex];
    bump.radius_mm = random.uniform(20, 45);
    bump.direction = (bump.centre - middle).normalized() * recipe.irregularity_mm * random.normal();
    bumps.push_back(bump);
  }
  return bumps;
}

struct ActiveField {
  const VariationField* field = nullptr;
  double scale_mm = 0;
};

void collect(const std::map<std::string, double>& values, std::span<const VariationField> fields,
             const std::string& kind, std::vector<ActiveField>& active) {
  for (const auto& [name, value] : values) {
    const auto found =
        std::find_if(fields.begin(), fields.end(),
                     [&name = name](const VariationField& field) { return field.variation.name == name; });
    if (found == fields.end()) {
      std::string known;
      for (const VariationField& field : fields) known += (known.empty() ? "" : ", ") + field.variation.name;
      throw InvalidInput("no " + kind + " is called '" + name + "'", "known: " + known);
    }
    if (!std::isfinite(value)) throw InvalidInput(kind + " " + name + " is not a number");
    if (value != 0) active.push_back({&*found, value * found->variation.amplitude_mm});
  }
}

Vector3d evaluate(const ActiveField& active, const Anatomy& anatomy, const Vector3d& p,
                  const RegionWeights& weights) {
  Vector3d moved = active.field->field(anatomy, p, weights);
  if (active.field->is_left_half) moved += mirrored(active.field->field(anatomy, mirrored(p), weights));
  return active.scale_mm * moved;
}

std::vector<Variation> list_variations(std::span<const VariationField> fields) {
  std::vector<Variation> list;
  for (const VariationField& field : fields) list.push_back(field.variation);
  return list;
}

}  // namespace

std::span<const Variation> list_sliders() {
  static const std::vector<Variation> list = list_variations(slider_fields());
  return list;
}

std::span<const Variation> list_expressions() {
  static const std::vector<Variation> list = list_variations(expression_fields());
  return list;
}

Anatomy measure_anatomy(const SubjectBase& base) {
  const auto at = [&](const std::string& name) {
    const auto found = base.landmarks.find(name);
    if (found == base.landmarks.end()) throw InvalidInput("the generic head has no landmark '" + name + "'");
    return position_at(found->second, base.triangles, base.positions);
  };
  Anatomy a;
  a.eye = 0.5 * (at("eye_left_inner_corner") + at("eye_left_outer_corner"));
  a.eye_upper = 0.5 * (at("eye_left_upper_inner") + at("eye_left_upper_outer"));
  a.brow = at("brow_left_2");
  a.inner_brow = at("brow_left_0");
  a.sellion = on_midline(at("nose_bridge_0"));
  a.bridge = on_midline(at("nose_bridge_1"));
  a.nose_tip = on_midline(at("nose_tip"));
  a.subnasale = on_midline(at("subnasale"));
  a.ala = at("nose_base_left_outer");
  a.upper_lip = on_midline(at("mouth_outer_03"));
  a.lower_lip = on_midline(at("mouth_outer_09"));
  a.stomion = on_midline(0.5 * (at("mouth_inner_02") + at("mouth_inner_06")));
  a.mouth_corner = at("mouth_left_corner");
  a.chin = on_midline(at("chin"));
  a.jaw_angle = at("jaw_12");
  a.tragus = at("tragus_left");
  a.ear_lobe = at("ear_lobe_left");
  a.ear_top = at("ear_top_left");
  a.cheekbone = 0.45 * at("eye_left_outer_corner") + 0.55 * at("jaw_14");
  a.cheek = 0.5 * (a.mouth_corner + at("jaw_14"));
  a.crown_y = -1e300;
  a.back_z = 1e300;
  for (const Vector3d& p : base.positions) {
    a.crown_y = std::max(a.crown_y, p.y());
    a.back_z = std::min(a.back_z, p.z());
  }
  for (const int vertex_idx : base.neck_loop) {
    a.neck_low_y += base.positions[vertex_idx].y() / static_cast<double>(base.neck_loop.size());
    a.neck_axis_z += base.positions[vertex_idx].z() / static_cast<double>(base.neck_loop.size());
  }
  return a;
}

SubjectRecipe draw_recipe(std::uint64_t seed, double spread) {
  SubjectRecipe recipe;
  RandomStream random({seed, 0x736c6964});
  for (const VariationField& field : slider_fields()) {
    recipe.sliders[field.variation.name] = std::clamp(spread * random.normal(), -kLimit, kLimit);
  }
  recipe.irregularity_mm = spread * kDrawnIrregularityMm;
  recipe.irregularity_seed = seed;
  return recipe;
}

std::vector<Eigen::Vector3d> make_subject(const SubjectBase& base, const SubjectRecipe& recipe) {
  std::vector<ActiveField> active;
  collect(recipe.sliders, slider_fields(), "slider", active);
  collect(recipe.expressions, expression_fields(), "expression", active);
  if (!std::isfinite(recipe.irregularity_mm)) throw InvalidInput("the irregularity is not a number");
  const std::vector<Irregularity> bumps = draw_irregularities(base, recipe);
  std::vector<Vector3d> positions = base.positions;
  if (active.empty() && bumps.empty()) return positions;
  const Anatomy anatomy = measure_anatomy(base);
  const std::vector<double>&ears = base.regions.at("ears"), &neck = base.regions.at("neck"),
        &mouth = base.regions.at("inner_mouth");
  parallel_for(positions.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const Vector3d& p = base.positions[v];
      Vector3d moved = Vector3d::Zero();
      for (const ActiveField& field : active)
        moved += evaluate(field, anatomy, p, {ears[v], neck[v], mouth[v]});
      for (const Irregularity& rise : bumps) {
        moved += rise.direction * bump(p, rise.centre, rise.radius_mm, rise.radius_mm, rise.radius_mm);
      }
      positions[v] = p + moved;
    }
  });
  return positions;
}

}  // namespace phiz
