#include "tests/stages/synth/synth_samples.h"

#include <fstream>

namespace phiz::test {

ControlMesh read_generic_head() {
  const std::string folder = PHIZ_GENERIC_HEAD;
  std::ifstream obj(folder + "/head.obj"), json(folder + "/head.json");
  return read_control_mesh(obj, json);
}

const SubjectBase& generic_base(int level) {
  static std::map<int, SubjectBase> made;
  const auto found = made.find(level);
  if (found != made.end()) return found->second;
  return made.emplace(level, make_subject_base(read_generic_head(), level)).first->second;
}

ScanTarget make_plain_target(TriangleMesh mesh) {
  ScanTarget target;
  target.materials.assign(mesh.positions.size(), ScanMaterial::kSkin);
  mesh.colours.assign(mesh.positions.size(), {200, 150, 120});
  target.mesh = std::move(mesh);
  return target;
}

ScanOptions exact_scan(int points) {
  ScanOptions options;
  options.points = points;
  options.noise_mm = options.hair_noise_mm = options.eye_noise_mm = 0;
  options.hair_loss_low = options.hair_loss_high = options.eye_loss = 0;
  options.outlier_share = options.registration_deg = options.registration_mm = 0;
  return options;
}

}  // namespace phiz::test
