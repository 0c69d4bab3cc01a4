#include <algorithm>
#include <set>

#include "stages/deform/deform.h"
#include "stages/deform/learn.h"
#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/unwrap/unwrap.h"

namespace phiz {
namespace {

using Positions = std::vector<Eigen::Vector3d>;

constexpr int kLevel = 3;
constexpr double kSplitHalfWidthMm = 8;
constexpr float kSmallestMm = 0.01f;  ///< smaller vectors count as zero, so that windows stay small

Eigen::Vector3d mirrored(const Eigen::Vector3d& v) {
  return {-v.x(), v.y(), v.z()};
}

/// The mean of a field over control vertices and its mirror image.
Positions symmetrise(const ControlMesh& head, const Positions& vectors) {
  const std::vector<int>& mirror = head.annotations.mirror;
  if (mirror.size() != vectors.size())
    throw InvalidInput("the generic head does not know its mirror images: symmetric fields cannot be made");
  Positions result(vectors.size());
  for (std::size_t v = 0; v < vectors.size(); ++v)
    result[v] = 0.5 * (vectors[v] + mirrored(vectors[mirror[v]]));
  return result;
}

/// 1 on the subject's left, 0 on the right, smooth between.
double leftness(double x_mm) {
  const double t = std::clamp(0.5 + 0.5 * x_mm / kSplitHalfWidthMm, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// Vectors over control vertices at the nodes of a grid, smooth in between (Modified Butterfly).
FieldImage draw(const UvChart& chart, const Positions& vectors, int side) {
  const Positions fine = evaluate_surface(chart.hierarchy, vectors, {}, chart.level);
  std::vector<float> values(3 * static_cast<std::size_t>(side) * side);
  parallel_for(static_cast<std::size_t>(side), 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y) {
      for (int x = 0; x < side; ++x) {
        const Eigen::Vector2d uv(x / (side - 1.0), 1 - static_cast<double>(y) / (side - 1.0));
        const SurfacePoint place = refine_place(chart.domain.locate(uv), chart.level);
        const Eigen::Vector3i& t = chart.hierarchy.triangles(chart.level)[place.triangle_idx];
        Eigen::Vector3f value = Eigen::Vector3f::Zero();
        for (int i = 0; i < 3; ++i) value += (place.weights[i] * fine[t[i]]).cast<float>();
        if (value.norm() < kSmallestMm) value.setZero();
        for (int axis = 0; axis < 3; ++axis) values[3 * (y * side + x) + axis] = value[axis];
      }
    }
  });
  return crop_field_image(side, side, 3, values);
}

/// Adds field, parameter and control of one name at the end of the chain.
void append(const std::string& name, FieldImage image, FieldType type, const std::string& origin,
            Deformation& rig) {
  DeformationField field;
  field.name = name;
  field.type = type;
  field.inputs = {rig.output};
  field.parameter = name;
  field.image = std::move(image);
  field.origin = origin;
  rig.fields.push_back(std::move(field));
  rig.parameters.push_back({name, 0, 1.1});
  RigControl control;
  control.name = name;
  control.terms = {{name, 1.0}};
  std::string pascal = name;
  pascal[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(pascal[0])));
  if (pascal != name) control.aliases = {pascal};
  rig.controls.push_back(std::move(control));
  rig.output = name;
}

}  // namespace

Deformation make_learned_rig(const ControlMesh& generic_head, const HeadAsset& neutral,
                             const std::map<std::string, Positions>& displacements_mm,
                             const std::string& origin, const FieldOptions& options) {
  if (options.side < 16 || options.side > 4096) throw InvalidInput("a field has 16 to 4096 nodes a side");
  const UvChart chart = make_uv_chart(generic_head.uv, generic_head.triangles, kLevel);
  Positions control;
  for (const Eigen::Vector3f& p : neutral.positions) control.push_back(p.cast<double>());
  const std::vector<Eigen::Quaterniond> frames = LocalFrames(generic_head).compute(control);

  Deformation rig;
  rig.template_digest = neutral.template_digest;
  rig.width = rig.height = options.side;
  DeformationField surface;
  surface.name = rig.output = "neutral";
  surface.type = FieldType::kConstant;
  surface.origin = "the subject's own surface";
  rig.fields.push_back(surface);
  const bool is_local = options.axes == FieldAxes::kLocal;
  const FieldType type = is_local ? FieldType::kAddLocal : FieldType::kAdd;
  for (const auto& [name, displacements] : displacements_mm) {
    if (displacements.size() != control.size())
      throw InvalidInput("'" + name + "' has another number of control vertices than the generic head");
    Positions vectors = displacements;
    if (is_local)
      for (std::size_t v = 0; v < vectors.size(); ++v) vectors[v] = frames[v].conjugate() * vectors[v];
    if (options.is_symmetric) vectors = symmetrise(generic_head, vectors);
    if (!options.is_split) {
      append(name, draw(chart, vectors, options.side), type, origin, rig);
      continue;
    }
    Positions left = vectors, right = vectors;
    for (std::size_t v = 0; v < vectors.size(); ++v) {
      const double share = leftness(generic_head.positions[v].x());
      left[v] *= share;
      right[v] *= 1 - share;
    }
    append(name + "Left", draw(chart, left, options.side), type, origin, rig);
    append(name + "Right", draw(chart, right, options.side), type, origin, rig);
  }
  check_deformation(rig);
  return rig;
}

}  // namespace phiz
