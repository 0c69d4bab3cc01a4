#pragma once

#include <fstream>
#include <memory>
#include <stdexcept>

#include "formats/control_mesh.h"
#include "formats/face_anatomy.h"
#include "stages/animate/animate.h"

namespace phiz::test {

inline ControlMesh load_head() {
  const std::string folder = PHIZ_SOURCE_FOLDER "/samples/generic_head/";
  std::ifstream obj(folder + "head.obj"), json(folder + "head.json");
  return read_control_mesh(obj, json);
}

inline FaceAnatomy load_anatomy() {
  std::ifstream in(PHIZ_SOURCE_FOLDER "/samples/anatomy/face.json");
  return read_face_anatomy(in);
}

/// The generic head with its anatomy, laid out once for all tests of a program.
inline const ControlMesh& generic_head() {
  static const ControlMesh head = load_head();
  return head;
}
inline std::shared_ptr<const FaceLayout> generic_layout() {
  static const auto layout = std::make_shared<const FaceLayout>(generic_head(), load_anatomy());
  return layout;
}

/// Activations by name, the others 0.
inline std::vector<float> activate(const FaceLayout& layout, const Activations& wanted) {
  std::vector<float> values(layout.activations().size(), 0.0f);
  for (const auto& [name, amount] : wanted) {
    const int index = layout.find_activation(name);
    if (index < 0) throw std::runtime_error(name);
    values[index] = static_cast<float>(amount);
  }
  return values;
}

}  // namespace phiz::test
