#include "orchestrator/tasks/retarget.h"

#include <fmt/format.h>

#include <sstream>

#include "formats/triangle_mesh.h"
#include "stages/geometry/error.h"

namespace phiz {

RetargetPlan::RetargetPlan(Deformation rig, const ControlMesh& generic_head, ParameterTrack track, int level)
    : rig_(std::move(rig)),
      track_(std::move(track)),
      maker_(generic_head, level),
      fields_(sample_fields(rig_, maker_.uv())) {
  for (DeformationField& field : rig_.fields) {
    if (field.type != FieldType::kConstant)
      field.image.values.clear(), field.image.width = field.image.height = 0;
  }  // sampled: the images are not needed any more
}

RetargetPlan::Outcome RetargetPlan::run(const std::string& subject, const HeadAsset& head,
                                        RetargetFormat format, const Door& door) const {
  std::vector<Eigen::Vector3d> control;
  for (const Eigen::Vector3f& p : head.positions) control.push_back(p.cast<double>());
  const NeutralSurface neutral = maker_.make(control, head.displacements_mm);
  const CompiledCascade cascade(rig_, fields_, neutral);
  Outcome outcome;
  outcome.figures = measure_motion(cascade, neutral, track_);
  const Door counting{[&](const std::string& name, const std::string& bytes) {
                        outcome.bytes += bytes.size();
                        door.write(name, bytes);
                      },
                      [&](const std::string& name) {
                        const auto size = door.has(name);
                        outcome.bytes += size.value_or(0);
                        return size;
                      }};
  if (format == RetargetFormat::kGlb) {
    const AnimatedMesh animated =
        make_animated_mesh(cascade, neutral, rig_, track_, maker_.hierarchy().triangles(maker_.level()));
    outcome.morph_error_mm = measure_morph_error(cascade, animated, track_);
    std::ostringstream out;
    write_animated_glb(animated, out);
    counting.write(subject + ".glb", std::move(out).str());
  }
  if (format == RetargetFormat::kObj) write_frames(subject, cascade, neutral, counting);
  return outcome;
}

void RetargetPlan::write_frames(const std::string& subject, const CompiledCascade& cascade,
                                const NeutralSurface& neutral, const Door& door) const {
  TriangleMesh mesh;
  mesh.triangles = maker_.hierarchy().triangles(maker_.level());
  mesh.positions.resize(cascade.point_count());
  for (const Eigen::Vector2d& uv : neutral.uv) mesh.uv.push_back(uv.cast<float>());
  for (std::size_t i = 0; i < track_.frame_count(); ++i) {
    const std::string name = fmt::format("{}/frame_{:05}.obj", subject, i);
    if (door.has(name)) continue;
    cascade.evaluate(track_.frame(i), mesh.positions);
    std::ostringstream out;
    write_obj(mesh, out);
    door.write(name, std::move(out).str());
  }
}

}  // namespace phiz
