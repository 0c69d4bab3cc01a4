#include "tests/stages/template/template_samples.h"

#include <fstream>
#include <sstream>

namespace phiz::test {
namespace {

const std::string kFolder = std::string(PHIZ_SOURCE_FOLDER) + "/samples/generic_head/";

}  // namespace

const ControlMesh& generic_head() {
  static const ControlMesh head = [] {
    std::ifstream mesh(kFolder + "head.obj"), annotations(kFolder + "head.json");
    return read_control_mesh(mesh, annotations);
  }();
  return head;
}

std::string generic_layout_text() {
  std::ostringstream text;
  text << std::ifstream(kFolder + "layout").rdbuf();
  return text.str();
}

Layout to_layout(const std::string& text) {
  std::istringstream in(text);
  return parse_layout(in);
}

std::string small_layout_text() {
  return "# corners of the half square\n"
         "point throat 0.5 0\n"
         "point nape 0.5 1\n"
         "free 0 0\n"
         "free 0 1\n"
         "point nose 0.5 0.4   # on the mirror line\n"
         "point a 0.2 0.3\n"
         "point b 0.35 0.3\n"
         "point c 0.28 0.5\n"
         "free x0 0.1 0.7\n"
         "curve eye closed a! b c\n"
         "flow ridge throat nose nape\n"
         "edge c x0\n"
         "region eye_right eye_left at 0.28 0.35 within eye\n"
         "region skin at 0.05 0.5 within eye also eye_right\n"
         "landmark tip 0.5 0.4\n"
         "landmark lid_right lid_left 0.28 0.35\n"
         "box eye_right eye_left eye_right 2\n"
         "bind a b\n"
         "constrain eye_right\n"
         "constrain eye\n"
         "plane neck 1 0 -80\n"
         "scale 2 0 0 50 10 40\n";
}

std::vector<std::string> list_short(const std::vector<HeadCheck>& checks) {
  std::vector<std::string> names;
  for (const HeadCheck& check : checks) {
    if (!check.ok) names.push_back(check.what);
  }
  return names;
}

std::string find_value(const std::vector<HeadCheck>& checks, const std::string& what) {
  for (const HeadCheck& check : checks) {
    if (check.what == what) return check.value;
  }
  return "not measured";
}

}  // namespace phiz::test
