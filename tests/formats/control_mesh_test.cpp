#include "formats/control_mesh.h"

#include <gtest/gtest.h>

#include <sstream>

#include "tests/formats/hostile_bytes.h"

namespace phiz {
namespace {

/// A folded square of four triangles about vertex 4, its annotations of every kind.
ControlMesh sample_mesh() {
  ControlMesh mesh;
  mesh.positions = {{-50, 0, 10.5}, {50, 0, 10.5}, {50, 100, -1e-9}, {-50, 100, 0}, {0, 51.234567891, 30}};
  mesh.uv = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 1.0 / 3.0}};
  mesh.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  Annotations& notes = mesh.annotations;
  notes.boxes["nose"] = Eigen::AlignedBox3d(Eigen::Vector3d(-1, 2, 3), Eigen::Vector3d(4, 5.125, 6));
  notes.boxes["ear_left"] = Eigen::AlignedBox3d(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 1, 1));
  notes.landmarks["nose.tip"] = {2, Eigen::Vector3d(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0)};
  notes.landmarks["chin"] = {0, Eigen::Vector3d(1, 0, 0)};
  notes.regions["face"] = {0, 1, 4};
  notes.regions["nothing"] = {};
  notes.binding_edges = {{3, 1}, {0, 2}};
  notes.constrained_vertices = {2, 3};
  notes.clipping_planes["neck"] = {Eigen::Vector3d(0, 0.6, 0.8), -12.5};
  notes.mirror = {1, 0, 3, 2, 4};
  return mesh;
}

struct Files {
  std::string obj, json;
  bool operator==(const Files&) const = default;
};

Files write(const ControlMesh& mesh) {
  std::ostringstream obj, json;
  write_control_mesh(mesh, obj, json);
  return {obj.str(), json.str()};
}

ControlMesh read(const Files& files) {
  std::istringstream obj(files.obj), json(files.json);
  return read_control_mesh(obj, json);
}

std::string fault_of(const Files& files) {
  try {
    read(files);
  } catch (const FormatError& error) {
    return error.what();
  }
  return {};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(ControlMesh, ReadsWhatItWrote) {
  const ControlMesh mesh = sample_mesh();
  const ControlMesh copy = read(write(mesh));
  ASSERT_EQ(copy.positions.size(), mesh.positions.size());
  ASSERT_EQ(copy.uv.size(), mesh.uv.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    EXPECT_LE((copy.positions[i] - mesh.positions[i]).cwiseAbs().maxCoeff(), 0.51e-6);
    EXPECT_LE((copy.uv[i] - mesh.uv[i]).cwiseAbs().maxCoeff(), 0.51e-6);
  }
  EXPECT_EQ(copy.triangles, mesh.triangles);
  const Annotations &notes = copy.annotations, &truth = mesh.annotations;
  ASSERT_EQ(notes.boxes.size(), 2u);
  EXPECT_EQ(notes.boxes.at("nose").min(), truth.boxes.at("nose").min());
  EXPECT_EQ(notes.boxes.at("nose").max(), truth.boxes.at("nose").max());
  ASSERT_EQ(notes.landmarks.size(), 2u);
  EXPECT_EQ(notes.landmarks.at("nose.tip").triangle_idx, 2);
  EXPECT_TRUE(notes.landmarks.at("nose.tip").weights.isApprox(truth.landmarks.at("nose.tip").weights, 2e-6));
  EXPECT_EQ(notes.regions, truth.regions);
  EXPECT_EQ(notes.binding_edges, truth.binding_edges);
  EXPECT_EQ(notes.constrained_vertices, truth.constrained_vertices);
  EXPECT_EQ(notes.clipping_planes.at("neck").normal, truth.clipping_planes.at("neck").normal);
  EXPECT_EQ(notes.clipping_planes.at("neck").offset_mm, -12.5);
  EXPECT_EQ(notes.mirror, truth.mirror);
}

TEST(ControlMesh, WritesTheSameBytesAfterReading) {
  const Files files = write(sample_mesh());
  EXPECT_EQ(write(read(files)), files);
  EXPECT_EQ(files.obj.find("-0.000000"), std::string::npos);
}

TEST(ControlMesh, ReadsAnObjOfAnotherProgram) {
  const Files files = write(sample_mesh());
  const std::string obj =
      "mtllib a.mtl\r\no head\r\n\r\nv  -50 0\t1.05e1 \r\nv 50 0 10.5\r\nv 50 100 0\r\n"
      "v -50 100 0\r\nvt 0 0\r\nvt 1 0\r\nvt 1 1\r\nvt 0 1\r\nvn 0 0 1\r\ns 1\r\n"
      "f 1/1/1 2/2/1 3/3/1\r\nf 1/1 3/3 4/4";
  const std::string empty =
      "{\"binding_edges\":[],\"boxes\":{},\"clipping_planes\":{},\"constrained_vertices\":[],"
      "\"landmarks\":{},\"mirror\":[],\"regions\":{},\"schema\":\"phiz.control_mesh.1\"}";
  const ControlMesh mesh = read({obj, empty});
  EXPECT_EQ(mesh.positions[0], Eigen::Vector3d(-50, 0, 10.5));
  EXPECT_EQ(mesh.triangles[1], Eigen::Vector3i(0, 2, 3));
}

TEST(ControlMesh, NamesTheLineOfAFault) {
  const Files good = write(sample_mesh());
  const auto fault = [&good](const std::string& from, const std::string& to) {
    return fault_of({replaced(good.obj, from, to), good.json});
  };
  EXPECT_EQ(fault("v -50.000000", "v fifty"), "'fifty' is not a number (line 2)");
  EXPECT_EQ(fault("v -50.000000", "v nan"), "position is not finite or beyond 1 km (vertex 0)");
  EXPECT_EQ(fault("v -50.000000 0.000000", "v 1"), "expected 3 numbers (line 2)");
  EXPECT_EQ(fault("vt 1.000000", "vt 1.500000"), "(u,v) is not in [0,1] (vertex 1)");
  EXPECT_EQ(fault("f 1/1 2/2 5/5", "f 1/1 2/3 5/5"), "vt and v differ in '2/3' (line 12)");
  EXPECT_EQ(fault("f 1/1 2/2 5/5", "f 1/1 2 5/5"), "'2' is not vertex/texture, counted from 1 (line 12)");
  EXPECT_EQ(fault("f 1/1 2/2 5/5", "f 1/1 2/2"), "a face needs three corners (line 12)");
  EXPECT_EQ(fault("f 1/1 2/2 5/5", "f 1/1 2/2 5/5 3/3"), "a face has more than three corners (line 12)");
  EXPECT_EQ(fault("f 1/1 2/2 5/5", "f 1/1 2/2 6/6"), "index 5 is not below 5 (triangle 0)");
  EXPECT_EQ(fault("f 1/1 2/2 5/5", "f 1/1 1/1 5/5"), "a vertex is repeated (triangle 0)");
  EXPECT_EQ(fault("vt 0.500000 0.333333\n", ""), "5 vertices but 4 (u,v)");
  EXPECT_EQ(fault("f 1/1 2/2 5/5", "l 1 2"), "'l' has no place in a control mesh (line 12)");
  EXPECT_EQ(fault_of({"", good.json}), "no vertices");
}

TEST(ControlMesh, NamesTheKeyOfAFault) {
  const Files good = write(sample_mesh());
  const std::string where = "its annotations, in the .json: ";
  const auto fault = [&](const std::string& from, const std::string& to) {
    const std::string what = fault_of({good.obj, replaced(good.json, from, to)});
    return what.starts_with(where) ? what.substr(where.size()) : what;
  };
  EXPECT_EQ(fault_of({good.obj, replaced(good.json, "\"mirror\"", "\"mirors\"")}),
            where + "missing key 'mirror'");
  EXPECT_EQ(fault("\"schema\"", "\"extra\": 1, \"schema\""), "unknown key 'extra'");
  EXPECT_EQ(fault("control_mesh.1", "control_mesh.7"), "is not \"phiz.control_mesh.1\" (schema)");
  EXPECT_EQ(fault("\"offset_mm\": -12.5", "\"offset\": 1"), "missing key 'offset_mm' (clipping_planes.neck)");
  EXPECT_EQ(fault("[0, 0.6, 0.8]", "[0, 0.6, 0.9]"),
            "normal is not of length 1 (clipping_planes.neck.normal)");
  EXPECT_EQ(fault("\"triangle\": 2", "\"triangle\": 4"),
            "index 4 is not below 4 (landmarks.nose.tip.triangle)");
  EXPECT_EQ(fault("[1, 0, 0]", "[1, 0, \"x\"]"), "is not a number (landmarks.chin.weights[2])");
  EXPECT_EQ(fault("[1, 0, 0]", "[1, 0.5, -0.5]"),
            "weights are not in [0,1] with sum 1 (landmarks.chin.weights)");
  EXPECT_EQ(fault("[0, 1, 4]", "[1, 0, 4]"), "indices do not ascend (regions.face)");
  EXPECT_EQ(fault("[0, 1, 4]", "[0, 1, 5]"), "index 5 is not below 5 (regions.face[2])");
  EXPECT_EQ(fault("[0, 1, 4]", "[0, 1, 4.5]"), "is not an integer (regions.face[2])");
  EXPECT_EQ(fault("[0, 2]", "[0, 2, 3]"), "is not a pair of vertices (binding_edges[1])");
  EXPECT_EQ(fault("[1, 0, 3, 2, 4]", "[1, 2, 3, 0, 4]"),
            "is not the mirror image of its mirror image (mirror[0])");
  EXPECT_EQ(fault("[-1, 2, 3]", "[-1, 2, 13]"), "min is above max or not finite (boxes.nose)");
  EXPECT_EQ(fault("\"nose\"", "\"no\\nse\""), "names have only letters, digits, '_', '-' and '.' (boxes)");
  EXPECT_EQ(fault("{", "["), "is not JSON (byte 20)");
  EXPECT_EQ(fault_of({good.obj, "[]"}), where + "is not an object");
}

TEST(ControlMesh, RefusesToWriteWhatCannotBeRead) {
  ControlMesh mesh = sample_mesh();
  mesh.positions[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write(mesh), FormatError);
  mesh = sample_mesh();
  mesh.annotations.regions["face"].push_back(9);
  EXPECT_THROW(write(mesh), FormatError);
}

TEST(ControlMesh, SurvivesTruncationAndNoise) {
  const Files files = write(sample_mesh());
  test::expect_mutations_survived(files.obj, 5000, [&](const std::string& obj) { read({obj, files.json}); });
  test::expect_mutations_survived(files.json, 5000, [&](const std::string& json) {
    read({files.obj, json});
  });
  const std::string json = files.json.substr(0, files.json.size() - 1);  // the last line's end may be missing
  test::expect_prefixes_refused(json, 1, [&](const std::string& text) { read({files.obj, text}); });
  for (std::size_t length = 0; length < files.obj.size(); ++length) {
    try {
      read({files.obj.substr(0, length), files.json});
    } catch (const FormatError&) {
    }
  }
}

TEST(ControlMesh, PositionOfASurfacePointIsTheWeightedMeanOfItsCorners) {
  const ControlMesh mesh = sample_mesh();
  const SurfacePoint point{1, Eigen::Vector3d(0.5, 0.25, 0.25)};
  const Eigen::Vector3d expected =
      0.5 * mesh.positions[1] + 0.25 * mesh.positions[2] + 0.25 * mesh.positions[4];
  EXPECT_TRUE(position_at(point, mesh.triangles, mesh.positions).isApprox(expected));
}

}  // namespace
}  // namespace phiz
