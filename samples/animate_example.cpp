// A fitted head smiles: control mesh simulated, surface evaluated, the last frame written.
// phiz_animate_example HEAD.glb ANATOMY.json GENERIC_HEAD.obj GENERIC_HEAD.json OUT.obj
#include <fstream>
#include <iostream>

#include "formats/head_asset.h"
#include "stages/animate/animate.h"

int main(int argc, char** argv) try {
  using namespace phiz;
  if (argc != 6) throw std::runtime_error("usage: HEAD.glb ANATOMY.json GENERIC.obj GENERIC.json OUT.obj");
  std::ifstream asset(argv[1], std::ios::binary), face(argv[2]), obj(argv[3]), json(argv[4]);
  const ControlMesh generic_head = read_control_mesh(obj, json);
  const HeadAsset head = read_head_asset(asset);
  const auto layout = std::make_shared<FaceLayout>(generic_head, read_face_anatomy(face));
  const SubdivisionHierarchy hierarchy(head.triangles, layout->vertex_count(), 2);
  std::vector<Eigen::Vector3d> rest;
  for (const Eigen::Vector3f& p : head.positions) rest.push_back(p.cast<double>());
  Skin skin(layout, rest);
  LivingSurface surface(std::make_shared<SurfacePlan>(hierarchy), head.displacements_mm);
  const std::pair<std::string, double> smile{"smile", 0.8};
  skin.set_activations(pose_activations(*layout, {&smile, 1}));
  for (int frame = 0; frame < 60; ++frame) {
    skin.step(1.0 / 60);
    surface.evaluate(skin.positions(), 2);  // draw surface.positions()
  }
  TriangleMesh mesh{{}, hierarchy.triangles(2), {}, {}, {}};
  for (const Point4& p : surface.positions()) mesh.positions.emplace_back(p.x, p.y, p.z);
  std::ofstream out(argv[5]);
  write_obj(mesh, out);
  return 0;
} catch (const std::exception& error) {
  std::cerr << "error: " << error.what() << "\n";
  return 1;
}
