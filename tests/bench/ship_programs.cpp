#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/glb_chunks.h"
#include "tests/bench/ship.h"

namespace phiz::bench {
namespace {

bool is_there(const std::string& program) {
  return std::system(("command -v " + program + " >/dev/null 2>&1").c_str()) == 0;
}

const std::string kViewer = PHIZ_SOURCE_FOLDER "/samples/viewer";

std::string scratch_path(const ShipWorld& ship, const std::string& file) {
  return (ship.world.scratch / file).string();
}

void report_morphs(const ShipWorld& ship, const std::string& subject, const std::string& rig) {
  const std::string bytes = export_bytes(ship, subject, "expressions.glb", {"--rig", rig, "--level", "2"});
  const auto document = nlohmann::json::parse(split_glb(bytes).json);
  const double targets = static_cast<double>(document["meshes"][0]["primitives"][0]["targets"].size());
  const double vertices = document["accessors"][0]["count"].get<double>();
  const double dense = static_cast<double>(bytes.size());
  double sparse = 0;
  for (const auto& accessor : document["accessors"])
    if (accessor.contains("sparse")) sparse += accessor["sparse"]["count"].get<double>() * 14;
  const double whole = dense - sparse + targets * vertices * 12;
  Board& board = ship.world.board;
  board.add({fmt::format("{:.0f} morph targets on level 2 ({:.0f} vertices), glb over dense floats", targets,
                         vertices),
             dense / whole, "", at_most(1.0 / 3)});
  board.add({"GPU memory of it: positions, normals, (u,v), targets as dense float textures",
             (vertices * (12 + 12 + 8) + targets * vertices * 16) / (1 << 20),
             "MiB",
             {}});
}

void report_validator(const ShipWorld& ship, const std::string& subject) {
  Board& board = ship.world.board;
  const Bar bar = at_most(0);
  const std::string what = "gltf-validator: errors and warnings in every kind of .glb";
  if (!is_there("node") || !std::filesystem::exists(kViewer + "/node_modules/gltf-validator"))
    return board.add_missing(what, bar, "run npm ci in samples/viewer");
  export_bytes(ship, subject, "baked.glb", {"--level", "2"});
  export_bytes(ship, subject, "lods.glb", {"--lods", "3,2,1"});
  export_bytes(ship, subject, "confidence.glb", {"--confidence", "--asset-level", "2"});
  std::vector<std::string> words = {"/usr/bin/env", "node", kViewer + "/test/validate.mjs"};
  for (const std::string& file :
       {subject + ".glb", subject + "_small.glb", std::string("baked.glb"), std::string("lods.glb"),
        std::string("confidence.glb"), std::string("expressions.glb")})
    words.push_back(scratch_path(ship, file));
  const test::ProgramRun run = test::run_program(words);
  double issues = 0;
  std::istringstream lines(run.out);
  for (std::string line; std::getline(lines, line);) {
    int errors = 0, warnings = 0;
    if (std::sscanf(line.c_str(), "%d errors %d warnings", &errors, &warnings) == 2)
      issues += errors + warnings;
  }
  if (run.out.empty()) return board.add_missing(what, bar, run.err);
  board.add({what + ", 6 files", issues, "", bar});
}

/// What other programs say of our files, where they are installed: `program arguments` must end well and name
/// what is expected.
void report_reader(const ShipWorld& ship, const std::string& program, std::vector<std::string> arguments,
                   const std::vector<std::string>& expected) {
  Board& board = ship.world.board;
  if (!is_there(program)) return board.note(program + " is not installed: not measured");
  arguments.insert(arguments.begin(), {"/usr/bin/env", program});
  const test::ProgramRun run = test::run_program(arguments);
  double missing = run.exit_code == 0 ? 0 : 1;
  for (const std::string& word : expected) missing += (run.out + run.err).find(word) == std::string::npos;
  board.add({program + ": refused, or names and counts missing", missing, "", at_most(0)});
}

void report_others(const ShipWorld& ship, const std::string& subject) {
  export_bytes(ship, subject, "other.drc", {"--level", "2"});
  export_bytes(ship, subject, "other.exr", {"--size", "64"});
  export_bytes(ship, subject, "other.vdb", {});
  export_bytes(ship, subject, "other.obj", {"--level", "2"});
  report_reader(ship, "draco_decoder",
                {"-i", scratch_path(ship, "other.drc"), "-o", scratch_path(ship, "other.ply")}, {"Decoded"});
  report_reader(ship, "exrheader", {scratch_path(ship, "other.exr")}, {"P.X", "N.X", "conf.V", "phizSchema"});
  report_reader(ship, "vdb_print", {"-l", scratch_path(ship, "other.vdb")}, {"points"});
  const std::string script = scratch_path(ship, "blender.py");
  std::ofstream(script) << "import bpy,sys\nbpy.ops.import_scene.gltf(filepath=sys.argv[-1])\n"
                           "m=[o for o in bpy.data.objects if o.type=='MESH'][0]\n"
                           "print('vertices',len(m.data.vertices),'keys',len(m.data.shape_keys.key_blocks))\n"
                           "print('has','jawOpen' in m.data.shape_keys.key_blocks)\n";
  report_reader(ship, "blender", {"-b", "-P", script, "--", scratch_path(ship, "expressions.glb")},
                {"has True"});
}

void report_viewer(const ShipWorld& ship, const std::string& subject) {
  Board& board = ship.world.board;
  const Bar bar = at_most(400);
  const std::string what =
      "decode and evaluate level 4 in Chromium, scaled to 300,000 vertices, best of five";
  if (!is_there("node") || !is_there("chromium") ||
      !std::filesystem::exists(kViewer + "/node_modules/playwright-core"))
    return board.add_missing(what, bar, "needs node, chromium and npm ci in samples/viewer");
  const test::ProgramRun run = test::run_program({"/usr/bin/env", "node", kViewer + "/test/viewer.test.mjs",
                                                  scratch_path(ship, subject + "_small.glb"),
                                                  scratch_path(ship, "expressions.glb"), "--json"});
  const auto figures = nlohmann::json::parse(run.out, nullptr, false);
  if (!figures.is_object() || !figures.contains("decode_ms")) return board.add_missing(what, bar, run.err);
  const double vertices = ship.world.head.hierarchy.vertex_count(kFinestLevel);
  board.add({what, figures["decode_ms"].get<double>() * 300000 / vertices, "ms", bar});
  board.add({"first picture in the viewer from so much of the file",
             100 * figures["first_bytes"].get<double>() / figures["bytes"].get<double>(), "%", at_most(15)});
  board.add({fmt::format("viewer in Chromium: checks that fail, of {}", figures["checks"].get<int>()),
             static_cast<double>(figures["failed"].size()), "", at_most(0)});
  for (const auto& name : figures["failed"]) board.note("failed: " + name.get<std::string>());
}

}  // namespace

void measure_programs(const ShipWorld& ship) {
  const std::string subject = ship.subjects.front().name, rig = scratch_path(ship, "rig");
  const test::ProgramRun made =
      run_phiz(ship.store, {"fields", "muscles", "--from", PHIZ_SOURCE_FOLDER "/samples/muscles", "-o", rig});
  if (made.exit_code != 0) throw std::runtime_error("phiz fields muscles: " + made.err);
  report_morphs(ship, subject, rig);
  report_validator(ship, subject);
  report_others(ship, subject);
  report_viewer(ship, subject);
}

}  // namespace phiz::bench
