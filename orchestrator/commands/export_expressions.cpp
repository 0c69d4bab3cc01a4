#include "orchestrator/commands/export_expressions.h"

#include <algorithm>
#include <functional>
#include <sstream>

#include "formats/animated_mesh.h"
#include "formats/gltf.h"
#include "formats/head_asset.h"
#include "formats/text.h"
#include "orchestrator/commands/rig_files.h"
#include "orchestrator/error.h"
#include "orchestrator/tasks/head_surface.h"
#include "stages/deform/deform.h"
#include "stages/retarget/retarget.h"

namespace phiz {

std::string make_expression_file(const Session& session, const std::string& asset_bytes,
                                 const ExpressionExport& what) {
  if (what.level < 0 || what.level > 6) throw UsageError("--level is not from 0 to 6");
  std::istringstream in(asset_bytes);
  const HeadAsset head = read_head_asset(in);
  const TemplateFiles files = session.load_head(std::nullopt);
  const Deformation rig = load_rig(session, what.rig);
  check_same_template(rig.template_digest, files, what.rig);
  check_same_template(head.template_digest, files, "the head");
  const NeutralMaker maker(load_control_mesh(files), what.level);
  const SampledFields fields = sample_fields(rig, maker.uv());
  std::vector<Eigen::Vector3d> control;
  for (const Eigen::Vector3f& p : head.positions) control.push_back(p.cast<double>());
  const NeutralSurface neutral = maker.make(control, head.displacements_mm);
  const CompiledCascade cascade(rig, fields, neutral);
  std::optional<Motion> motion;
  if (what.motion) motion = load_motion(session, *what.motion);
  std::ostringstream out;
  write_animated_glb(make_expression_mesh(cascade, neutral, rig, motion ? &*motion : nullptr,
                                          maker.hierarchy().triangles(maker.level())),
                     out);
  return std::move(out).str();
}

std::string make_lod_file(const std::string& asset_bytes, const std::string& levels) {
  std::vector<int> wanted;
  std::istringstream words(levels);
  for (std::string word; std::getline(words, word, ',');) {
    int level = 0;
    if (!parse_number(std::string_view(word), level)) throw UsageError("--lods is a list of levels: 3,2,1");
    wanted.push_back(level);
  }
  std::sort(wanted.begin(), wanted.end(), std::greater<>());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  if (wanted.size() < 2) throw UsageError("--lods names two levels or more: 3,2,1");
  std::vector<TriangleMesh> meshes;
  for (const int level : wanted) meshes.push_back(evaluate_head(asset_bytes, {level, false}));
  std::ostringstream out;
  write_lod_glb(meshes, out);
  return std::move(out).str();
}

}  // namespace phiz
