// Writes the small files that the mutations start from: phiz_make_corpus tests/fuzz/corpus

#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

#include "formats/control_mesh.h"
#include "formats/distance_field.h"
#include "formats/geometry_image.h"
#include "formats/head_asset.h"
#include "formats/image.h"
#include "formats/motion.h"
#include "formats/point_cloud.h"
#include "store/pack.h"
#include "tests/formats/scan_samples.h"
#include "tests/store/memory_file_system.h"
#include "tests/support/mesh_zoo.h"

namespace phiz {
namespace {

namespace fs = std::filesystem;

class Corpus {
 public:
  explicit Corpus(fs::path folder) : folder_(std::move(folder)) {}
  void add(const std::string& target, const std::string& name, const std::string& bytes) const {
    fs::create_directories(folder_ / target);
    std::ofstream(folder_ / target / name, std::ios::binary) << bytes;
  }
  template <class Noun, class Write>
  void add_written(const std::string& target, const std::string& name, const Noun& noun,
                   const Write& write) const {
    std::ostringstream out;
    write(noun, out);
    add(target, name, out.str());
  }

 private:
  fs::path folder_;
};

void add_scans(const Corpus& corpus) {
  const test::ScanSample sample = test::make_sample();
  for (const auto& [name, kind] : {std::pair{"ascii", test::PlyKind::ascii},
                                   {"little", test::PlyKind::little},
                                   {"big", test::PlyKind::big}}) {
    corpus.add("ply", name, test::write_ply_as(kind, test::ply_columns(sample), sample.triangles));
    corpus.add("ply", std::string(name) + "_list",
               test::write_ply_as(kind, test::ply_columns(sample), {}, 2));
  }
  corpus.add("obj", "mesh", test::write_obj_text(sample));
  corpus.add("stl", "text", test::write_stl_text(sample));
  corpus.add("stl", "binary", test::write_stl_binary(sample));
  corpus.add("off", "mesh", test::write_off_text(sample));
  corpus.add("text", "spaces", test::write_columns(sample, " "));
  corpus.add("text", "commas", test::write_columns(sample, ","));
  corpus.add("glb", "plain", test::write_glb(sample));
  corpus.add("glb", "draco", test::write_draco_glb(sample));
  corpus.add("drc", "mesh", test::write_drc(sample, true));
  corpus.add("drc", "cloud", test::write_drc(sample, false));
  PointCloud cloud;
  cloud.positions = sample.positions;
  corpus.add_written("vdb", "points", cloud, [](const PointCloud& c, std::ostream& o) { write_vdb(c, o); });
}

void add_fields_and_pictures(const Corpus& corpus) {
  DistanceField field;
  field.voxel_mm = 1;
  field.truncation_mm = 3;
  for (int x = -3; x <= 3; ++x) {
    for (int y = -3; y <= 3; ++y) {
      field.coordinates.emplace_back(x, y, 0);
      field.distances_mm.push_back(0.5f * static_cast<float>(x));
      field.confidences.push_back(1);
    }
  }
  corpus.add_written("distance", "plane", field,
                     [](const DistanceField& f, std::ostream& o) { write_vdb(f, o); });
  GeometryImage image;
  image.width = image.height = 4;
  image.template_digest = "abc";
  for (int i = 0; i < 16; ++i) {
    image.positions.emplace_back(static_cast<float>(i), 1, 2);
    image.normals.emplace_back(0, 0, 1);
    image.colours.emplace_back(0.25f, 0.5f, 0.75f);
    image.confidences.push_back(0.5f);
    image.mask.push_back(i % 2 ? 1.0f : 0.0f);
  }
  for (const char* target : {"geometry", "exr"})
    corpus.add_written(target, "small", image, write_geometry_image);
  Image picture;
  picture.width = 3;
  picture.height = 2;
  picture.pixels.resize(6, {77, 78, 79});
  corpus.add_written("png", "small", picture, write_png);
}

void add_heads(const Corpus& corpus) {
  const TriangleMesh disk = test::disk(8, 2);
  HeadAsset head;
  head.template_digest = "0123456789abcdef";
  head.triangles = disk.triangles;
  ControlMesh mesh;
  mesh.triangles = disk.triangles;
  for (const Eigen::Vector3f& p : disk.positions) {
    head.positions.push_back(100.0f * p);
    head.uv.emplace_back(0.5f + 0.5f * p.x(), 0.5f + 0.5f * p.y());
    mesh.positions.push_back(100.0 * p.cast<double>());
    mesh.uv.emplace_back(0.5 + 0.5 * p.x(), 0.5 + 0.5 * p.y());
  }
  head.displacements_mm.emplace_back(disk.vertex_count(), 0.25f);
  head.confidences.emplace_back(disk.vertex_count(), std::uint8_t{255});
  corpus.add_written("head", "one_level", head,
                     [](const HeadAsset& h, std::ostream& o) { write_head_asset(h, {}, o); });
  mesh.annotations.regions["face"] = {0, 1, 2};
  mesh.annotations.binding_edges = {{0, 3}};
  mesh.annotations.landmarks["tip"] = {0, Eigen::Vector3d(0.5, 0.25, 0.25)};
  mesh.annotations.clipping_planes["neck"] = {};
  std::ostringstream obj, json;
  write_control_mesh(mesh, obj, json);
  corpus.add("template_obj", "disk", obj.str());
  corpus.add("template_json", "disk", json.str());
}

void add_motions(const Corpus& corpus) {
  Motion motion;
  motion.names = {"jawOpen", "HeadYaw"};
  for (int i = 0; i < 4; ++i) {
    motion.times_s.push_back(i / 60.0);
    motion.values.insert(motion.values.end(), {0.25f * static_cast<float>(i), 0.5f});
  }
  corpus.add_written("motion", "plain", motion, write_motion_csv);
  corpus.add_written("motion", "json", motion, write_motion_json);
  corpus.add_written("motion", "live_link", motion, write_live_link_csv);
}

void add_store(const Corpus& corpus) {
  test::MemoryFileSystem disk;
  const Store store = Store::open_or_create(disk, "/store");
  CommitRequest request;
  request.result.key_text.add("stage", "name", "fit");
  request.result.key_text.add("version", "number", "1");
  request.result.key_text.add("parameter", "rounds", "8");
  request.result.key_text.add("input", "scan", compute_digest("scan").hex());
  request.outputs = {{"head.glb", "some bytes"}, {"fit.json", "{}"}};
  SubjectRecord record{"head", "/scans/head.ply", compute_digest("scan"), 4, {}, {}};
  record.set_current("fit", compute_digest("a former one"));
  record.set_current("fit", request.result.key_text.key());
  request.subject = record;
  const Result result = store.commit(std::move(request)).result;
  const auto body = [&](const fs::path& file) {
    const std::string text = disk.read_file(file);
    return text.substr(0, text.rfind(",\n \"seal\"")) + "\n}";
  };
  corpus.add("result", "fit", body(store.layout().result(result.key())));
  corpus.add("subject", "head", body(store.layout().subject("head")));
  corpus.add("key", "fit", result.key_text.text());
  corpus.add("notes", "fit", format_notes({{"fit", make_note(result)}}));
  corpus.add("pack", "one", pack_subjects(store, {"head"}));
  corpus.add("checkpoint", "state", "phiz-checkpoint 1 " + compute_digest("state").hex() + "\nstate");
  corpus.add("list", "three",
             "subject,scan,units,join.steps\nfirst,a.xyz,mm,5\n\"second\",\"b \"\"c\".xyz,,\n# no\n");
  const std::string line = "2026-01-01T00:00:00.000Z host:1 head fit done 1 s";
  corpus.add("log", "line", compute_digest(line).hex().substr(0, 16) + " " + line + "\n");
}

}  // namespace
}  // namespace phiz

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: phiz_make_corpus FOLDER\n";
    return 2;
  }
  const phiz::Corpus corpus(argv[1]);
  phiz::add_scans(corpus);
  phiz::add_fields_and_pictures(corpus);
  phiz::add_heads(corpus);
  phiz::add_motions(corpus);
  phiz::add_store(corpus);
  return 0;
}
