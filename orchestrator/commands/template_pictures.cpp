#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "orchestrator/commands/template_files.h"
#include "stages/publish/views.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {
namespace {

using Colour = std::array<std::uint8_t, 3>;

constexpr Colour kClay = {205, 190, 178}, kRed = {205, 40, 40}, kOrange = {240, 150, 60},
                 kYellow = {245, 220, 110}, kBlue = {70, 110, 205}, kPaleBlue = {150, 185, 235},
                 kGreen = {90, 160, 90};
constexpr int kPictureWidth = 420, kPictureHeight = 480;
constexpr std::size_t kMostVertices = 20'000;  ///< larger meshes are not subdivided for a picture

/// Every triangle with corners of its own, so that each can have its own colour, with smooth normals.
TriangleMesh take_apart(const std::vector<Eigen::Vector3d>& positions,
                        const std::vector<Eigen::Vector3i>& triangles) {
  std::vector<Eigen::Vector3d> normals(positions.size(), Eigen::Vector3d::Zero());
  for (const auto& t : triangles) {
    const Eigen::Vector3d normal =
        (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]);
    for (int k = 0; k < 3; ++k) normals[t[k]] += normal;
  }
  TriangleMesh mesh;
  for (const auto& t : triangles) {
    const int first = static_cast<int>(mesh.positions.size());
    for (int k = 0; k < 3; ++k) {
      mesh.positions.push_back(positions[t[k]].cast<float>());
      mesh.normals.push_back(normals[t[k]].normalized().cast<float>());
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  mesh.colours.assign(mesh.positions.size(), kClay);
  return mesh;
}

void paint(TriangleMesh& mesh, std::size_t triangle_idx, const Colour& colour) {
  for (std::size_t k = 0; k < 3; ++k) mesh.colours[3 * triangle_idx + k] = colour;
}

/// An octahedron.
void add_mark(TriangleMesh& mesh, const Eigen::Vector3d& centre, double radius, const Colour& colour) {
  const int first = static_cast<int>(mesh.positions.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      const Eigen::Vector3d direction = sign * Eigen::Vector3d::Unit(axis);
      mesh.positions.push_back((centre + radius * direction).cast<float>());
      mesh.normals.push_back(direction.cast<float>());
      mesh.colours.push_back(colour);
    }
  }
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1, y = (corner >> 1) & 1, z = (corner >> 2) & 1;
    Eigen::Vector3i t(first + x, first + 2 + y, first + 4 + z);
    if ((x + y + z) % 2 == 1) std::swap(t[1], t[2]);
    mesh.triangles.push_back(t);
  }
}

/// A thin stick with three sides.
void add_stick(TriangleMesh& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
               const Colour& colour) {
  constexpr double kRadius_mm = 0.35;
  if ((to - from).norm() < 1e-6) return;
  const Eigen::Vector3d side = (to - from).unitOrthogonal(), other = (to - from).normalized().cross(side);
  const int first = static_cast<int>(mesh.positions.size());
  for (int k = 0; k < 3; ++k) {
    const double angle = 2.0943951 * k;
    const Eigen::Vector3d out = std::cos(angle) * side + std::sin(angle) * other;
    for (const Eigen::Vector3d& end : {from, to}) {
      mesh.positions.push_back((end + kRadius_mm * out).cast<float>());
      mesh.normals.push_back(out.cast<float>());
      mesh.colours.push_back(colour);
    }
  }
  for (int k = 0; k < 3; ++k) {
    const int a = first + 2 * k, b = first + 2 * ((k + 1) % 3);
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
  }
}

void add_box(TriangleMesh& mesh, const Eigen::AlignedBox3d& box) {
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      const int other = corner | (1 << axis);
      if (other == corner) continue;
      const auto place = [&](int c) -> Eigen::Vector3d {
        return {(c & 1 ? box.max() : box.min())[0], (c & 2 ? box.max() : box.min())[1],
                (c & 4 ? box.max() : box.min())[2]};
      };
      add_stick(mesh, place(corner), place(other), kBlue);
    }
  }
}

ViewOptions make_wireframe() {
  ViewOptions options;
  options.wireframe = true;
  return options;
}

/// A look: where from, at what.
struct Look {
  std::string label;
  Camera camera;
  std::optional<Eigen::AlignedBox3f> frame_mm = {};
};

class Painter {
 public:
  Painter(const ControlMesh& head, const std::vector<HeadCheck>& checks)
      : head_(head), checks_(checks), measures_(measure_head(head)) {
    for (const char* name : {"front", "side", "threequarter", "back"})
      round_.push_back({name, find_camera(name).value()});
    add_close_look("ear", "ear_right", {-90, 0});
    add_close_look("nose", "nose", {-30, -15});
    add_close_look("mouth", "mouth", {0, 0});
    add_eye_look();
  }

  std::map<std::string, Image> draw_all() {
    draw_sheet("wireframe", make_plain(), round_, make_wireframe());
    draw_valences();
    draw_angles();
    draw_loops();
    draw_symmetry();
    draw_landmarks();
    draw_regions();
    draw_domain();
    draw_stretch();
    draw_smooth();
    draw_sides();
    return std::move(pictures_);
  }

 private:
  TriangleMesh make_plain() const { return take_apart(head_.positions, head_.triangles); }

  void add_close_look(const char* label, const char* box_name, const Camera& camera) {
    const auto box = head_.annotations.boxes.find(box_name);
    if (box != head_.annotations.boxes.end() && !box->second.isEmpty())
      close_.push_back({label, camera, box->second.cast<float>()});
  }

  void add_eye_look() {
    const auto eyes = head_.annotations.regions.find("eyes");
    if (eyes == head_.annotations.regions.end()) return;
    Eigen::AlignedBox3f box;
    for (const int v : eyes->second) {
      if (head_.positions[v][0] < 0) box.extend(head_.positions[v].cast<float>());
    }
    if (box.isEmpty()) return;
    box.min().array() -= 8, box.max().array() += 8;
    close_.push_back({"eye", {-10, 0}, box});
  }

  /// What the checks of a picture say: the first that falls short, else how many hold.
  std::string make_title(const std::string& name) const {
    std::size_t count = 0;
    for (const HeadCheck& check : checks_) {
      if (check.picture != name) continue;
      if (!check.ok) return name + ": " + check.what + ": " + check.value + ", should be " + check.bar;
      ++count;
    }
    return name + ": " + std::to_string(count) + " checks, all hold";
  }

  void draw_sheet(const std::string& name, const TriangleMesh& mesh, const std::vector<Look>& looks,
                  ViewOptions options) {
    std::vector<std::vector<Image>> rows;
    std::vector<std::vector<std::string>> labels;
    options.width = kPictureWidth;
    options.height = kPictureHeight;
    options.use_colours = !options.heat;
    constexpr std::size_t kPerRow = 4;
    for (std::size_t k = 0; k < looks.size(); ++k) {
      if (k % kPerRow == 0) rows.emplace_back(), labels.emplace_back();
      options.camera = looks[k].camera;
      options.frame_mm = looks[k].frame_mm;
      rows.back().push_back(render_mesh(mesh, options));
      labels.back().push_back(looks[k].label);
    }
    pictures_[name] = contact_sheet(rows, labels, make_title(name));
  }

  std::vector<Look> list_all_looks() const {
    std::vector<Look> looks = round_;
    looks.insert(looks.end(), close_.begin(), close_.end());
    return looks;
  }

  void draw_valences() {
    if (measures_.valences.empty()) return;
    TriangleMesh mesh = make_plain();
    for (std::size_t v = 0; v < measures_.valences.size(); ++v) {
      const int valence = measures_.valences[v];
      if (valence == 0 || valence == 6) continue;
      const bool is_bad = valence < 4 || valence > 8, is_low = valence < 6;
      const bool is_near = valence == 5 || valence == 7;
      const Colour colour = is_bad              ? Colour{160, 30, 160}
                            : is_low && is_near ? kPaleBlue
                            : is_low            ? kBlue
                            : is_near           ? kOrange
                                                : kRed;
      add_mark(mesh, head_.positions[v], is_bad ? 2.5 : is_near ? 1.0 : 1.4, colour);
    }
    draw_sheet("valences", mesh, list_all_looks(), make_wireframe());
  }

  void draw_angles() {
    TriangleMesh mesh = make_plain();
    for (std::size_t t = 0; t < measures_.min_angles_deg.size(); ++t) {
      const double angle = measures_.min_angles_deg[t];
      if (angle < 30) paint(mesh, t, angle < 15 ? kRed : angle < 22 ? kOrange : kYellow);
    }
    draw_sheet("angles", mesh, list_all_looks(), make_wireframe());
  }

  void draw_loops() {
    TriangleMesh mesh = make_plain();
    for (const auto& [name, rings] : measures_.rings) {
      for (std::size_t t = 0; t < rings.size(); ++t) {
        if (rings[t] < 0 || rings[t] > 3) continue;
        paint(mesh, t, std::array<Colour, 4>{kRed, kYellow, kGreen, kPaleBlue}[rings[t]]);
      }
    }
    draw_sheet("loops", mesh, list_all_looks(), make_wireframe());
  }

  void draw_symmetry() {
    if (measures_.asymmetry_mm.empty()) return;
    TriangleMesh mesh;
    HeatMap heat;
    for (std::size_t v = 0; v < head_.positions.size(); ++v) {
      mesh.positions.push_back(head_.positions[v].cast<float>());
      heat.values.push_back(static_cast<float>(measures_.asymmetry_mm[v]));
    }
    mesh.triangles = head_.triangles;
    heat.high = std::max(0.01f, *std::max_element(heat.values.begin(), heat.values.end()));
    heat.caption = "mm";
    ViewOptions options;
    options.heat = heat;
    draw_sheet("symmetry", mesh, round_, options);
  }

  void draw_landmarks() {
    TriangleMesh mesh = make_plain();
    const auto& notes = head_.annotations;
    for (const int v : notes.constrained_vertices) add_mark(mesh, head_.positions[v], 0.7, kGreen);
    for (const auto& [a, b] : notes.binding_edges)
      add_stick(mesh, head_.positions[a], head_.positions[b], kOrange);
    for (const auto& [name, point] : notes.landmarks)
      add_mark(mesh, position_at(point, head_.triangles, head_.positions), 1.4, kRed);
    for (const auto& [name, box] : notes.boxes) add_box(mesh, box);
    draw_sheet("landmarks", mesh, list_all_looks(), {});
  }

  void draw_regions() {
    TriangleMesh mesh = make_plain();
    constexpr std::array<Colour, 8> kColours = {
        kPaleBlue, kYellow, kOrange, kGreen, kRed, Colour{190, 140, 200}, Colour{120, 200, 200}, kBlue};
    std::vector<std::pair<std::size_t, std::string>> by_size;
    for (const auto& [name, vertices] : head_.annotations.regions) by_size.push_back({vertices.size(), name});
    std::sort(by_size.rbegin(), by_size.rend());  // small ones lie on top
    for (std::size_t k = 0; k < by_size.size(); ++k) {
      std::vector<bool> inside(head_.positions.size(), false);
      for (const int v : head_.annotations.regions.at(by_size[k].second)) inside[v] = true;
      for (std::size_t t = 0; t < head_.triangles.size(); ++t) {
        const auto& tri = head_.triangles[t];
        if (inside[tri[0]] && inside[tri[1]] && inside[tri[2]]) paint(mesh, t, kColours[k % kColours.size()]);
      }
    }
    draw_sheet("regions", mesh, list_all_looks(), {});
  }

  /// The square itself, looked at from above; the face is pale, what is turned over is seen from behind.
  TriangleMesh make_square() const {
    std::vector<Eigen::Vector3d> positions;
    for (const auto& uv : head_.uv) positions.push_back({200 * uv[0], 200 * uv[1], 0});
    TriangleMesh mesh = take_apart(positions, head_.triangles);
    for (auto& normal : mesh.normals) normal = Eigen::Vector3f::UnitZ();
    return mesh;
  }

  void draw_domain() {
    TriangleMesh mesh = make_square();
    const auto face = head_.annotations.regions.find("face");
    std::vector<bool> inside(head_.positions.size(), false);
    if (face != head_.annotations.regions.end()) {
      for (const int v : face->second) inside[v] = true;
    }
    for (std::size_t t = 0; t < head_.triangles.size(); ++t) {
      const auto& tri = head_.triangles[t];
      paint(mesh, t, inside[tri[0]] && inside[tri[1]] && inside[tri[2]] ? Colour{235, 225, 215} : kPaleBlue);
      if (measures_.stretches[t][1] <= 0) paint(mesh, t, kRed);
    }
    ViewOptions options;
    options.width = options.height = 900;
    options.use_colours = options.wireframe = true;
    options.light = Light::kNone;
    pictures_["uv"] =
        contact_sheet({{render_mesh(mesh, options)}}, {{"u to the right, v upwards"}}, make_title("uv"));
  }

  void draw_stretch() {
    if (!(measures_.face_mm > 0)) return;
    HeatMap heat;
    for (const auto& stretch : measures_.stretches) {
      for (int k = 0; k < 3; ++k) heat.values.push_back(static_cast<float>(stretch[0] / measures_.face_mm));
    }
    heat.high = 4;
    heat.caption = "stretch";
    ViewOptions options;
    options.heat = heat;
    draw_sheet("stretch", make_plain(), round_, options);
  }

  /// Level 3 without displacements in grazing light; crossings are marked.
  void draw_smooth() {
    if (measures_.valences.empty() || head_.positions.size() > kMostVertices) return;
    constexpr int kLevel = 3, kFinestLevel = 4;
    const SubdivisionHierarchy hierarchy(head_.triangles, static_cast<int>(head_.positions.size()), kLevel);
    TriangleMesh mesh =
        take_apart(evaluate_surface(hierarchy, head_.positions, {}, kLevel), hierarchy.triangles(kLevel));
    const LimitSurface finest = find_limit_crossings(head_, kFinestLevel);
    for (const auto& pair : finest.crossings)
      add_mark(mesh, finest.positions[finest.triangles[pair.first][0]], 1, kRed);
    ViewOptions options;
    options.light = Light::kSide;
    draw_sheet("smooth", mesh, list_all_looks(), options);
  }

  /// Eight sides of levels 0 and 1 with their edges and of level 3 without.
  void draw_sides() {
    if (measures_.valences.empty() || head_.positions.size() > kMostVertices) return;
    constexpr int kWidth = 170, kHeight = 195;
    const std::array<Camera, 8> cameras = {
        {{0, 0}, {-45, 0}, {-90, 0}, {-135, 0}, {180, 0}, {60, 10}, {0, 60}, {0, -45}}};
    std::vector<std::vector<Image>> rows;
    std::vector<std::vector<std::string>> labels;
    for (const int level : {0, 1, 3}) {
      const SubdivisionHierarchy hierarchy(head_.triangles, static_cast<int>(head_.positions.size()), level);
      const TriangleMesh mesh =
          take_apart(evaluate_surface(hierarchy, head_.positions, {}, level), hierarchy.triangles(level));
      rows.emplace_back(), labels.emplace_back();
      for (const Camera& camera : cameras) {
        ViewOptions options;
        options.camera = camera;
        options.width = kWidth, options.height = kHeight;
        options.wireframe = level < 3;
        rows.back().push_back(render_mesh(mesh, options));
      }
      labels.back().push_back("level " + std::to_string(level));
    }
    pictures_["sides"] = contact_sheet(rows, labels);
  }

  const ControlMesh& head_;
  const std::vector<HeadCheck>& checks_;
  const HeadMeasures measures_;
  std::vector<Look> round_, close_;
  std::map<std::string, Image> pictures_;
};

}  // namespace

std::map<std::string, Image> draw_check_pictures(const ControlMesh& head,
                                                 const std::vector<HeadCheck>& checks) {
  return Painter(head, checks).draw_all();
}

}  // namespace phiz
