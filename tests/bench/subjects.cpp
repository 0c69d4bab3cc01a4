#include "tests/bench/subjects.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "formats/scan_file.h"

namespace phiz::bench {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

json load_json(const fs::path& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error(path.string() + ": cannot be read");
  return json::parse(in);
}

Eigen::Matrix4d to_matrix(const json& rows) {
  Eigen::Matrix4d matrix;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) matrix(row, column) = rows.at(row).at(column).get<double>();
  }
  return matrix;
}

double mm_per_unit(const std::string& unit) {
  if (unit == "cm") return 10;
  if (unit == "m") return 1000;
  if (unit == "in") return 25.4;
  return 1;
}

BenchSubject read_subject(const fs::path& folder, const json& entry) {
  BenchSubject subject;
  subject.scan = folder / entry.at("scan").get<std::string>();
  subject.name = subject.scan.stem().string();
  subject.truth = folder / entry.at("truth").get<std::string>();
  subject.scan_from_truth = to_matrix(entry.at("scan_from_truth"));
  subject.sample_pitch_scan = entry.value("sample_pitch_mm", 0.0) / mm_per_unit(entry.value("units", "mm"));
  subject.has_triangles = entry.value("triangles", 0) > 0;
  subject.points = entry.value("points", 0);
  if (!fs::exists(subject.scan)) throw std::runtime_error(subject.scan.string() + ": no such file");
  return subject;
}

TruthLabels read_labels(const fs::path& folder) {
  const json labels = load_json(folder / "truth" / "vertex_labels.json");
  TruthLabels result;
  result.narrow_face_last = labels.at("regions").at("narrow_face").at(1).get<int>();
  result.face_last = labels.at("regions").at("face").at(1).get<int>();
  result.skin_triangles = labels.at("skin_triangles").get<int>();
  result.is_hair.assign(labels.at("vertices").get<std::size_t>(), false);
  for (const json& vertex : labels.at("hair_vertices")) result.is_hair.at(vertex.get<std::size_t>()) = true;
  const json landmarks = load_json(folder / "truth" / "landmarks.json");
  for (const json& landmark : landmarks.at("landmarks")) {
    result.landmarks[landmark.at("name").get<std::string>()] = landmark.at("vertex").get<int>();
  }
  return result;
}

std::vector<BenchSubject> list_real(const fs::path& folder) {
  std::vector<BenchSubject> subjects;
  if (!fs::exists(folder)) return subjects;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    BenchSubject subject;
    subject.scan = entry.path();
    subject.name = subject.scan.stem().string();
    if (subject.scan.extension() != ".ply" || subject.name.ends_with("_mesh")) continue;
    subjects.push_back(subject);
  }
  std::sort(subjects.begin(), subjects.end(),
            [](const BenchSubject& a, const BenchSubject& b) { return a.name < b.name; });
  return subjects;
}

}  // namespace

std::optional<BenchData> find_bench_data() {
  const char* variable = std::getenv("PHIZ_DATA");
  const fs::path folder =
      variable && *variable ? fs::path(variable) : fs::path(PHIZ_SOURCE_FOLDER) / ".." / "shared" / "data";
  if (!fs::exists(folder / "subjects.json")) return std::nullopt;
  BenchData data;
  data.folder = fs::absolute(folder).lexically_normal();
  const json index = load_json(data.folder / "subjects.json");
  for (const json& entry : index.at("subjects")) {
    data.subjects.push_back(read_subject(data.folder, entry));
  }
  data.labels = read_labels(data.folder);
  for (BenchSubject& subject : list_real(data.folder / "real")) data.subjects.push_back(std::move(subject));
  return data;
}

TriangleMesh load_truth(const BenchSubject& subject) {
  const ScanFile file = read_scan_file(subject.truth);
  TriangleMesh mesh;
  for (const Eigen::Vector3f& position : file.points.positions) {
    mesh.positions.push_back((position.cast<double>() + file.origin).cast<float>());
  }
  mesh.triangles = file.triangles;
  return mesh;
}

}  // namespace phiz::bench
