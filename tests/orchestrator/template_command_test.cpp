// `phiz template` as a user runs it.

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "orchestrator/error_table.h"
#include "tests/e2e/program.h"
#include "tests/support/temp_folder.h"

namespace phiz {
namespace {

using test::ProgramRun;

const std::filesystem::path kHead = std::filesystem::path(PHIZ_SOURCE_FOLDER) / "samples" / "generic_head";

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::string read_text(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path) << text;
}

ProgramRun run_template(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {test::phiz_program().string(), "template"});
  return test::run_program(arguments);
}

TEST(TemplateCommand, ChecksOurHeadAndDrawsAPictureOfEachCheck) {
  test::TempFolder folder;
  const ProgramRun run = run_template({"check", kHead.string(), "-o", (folder / "pictures").string()});
  EXPECT_EQ(run.exit_code, kExitDone) << run.err;
  EXPECT_TRUE(has(run.out, "valences")) << run.out;
  EXPECT_FALSE(has(run.out, "SHORT")) << run.out;
  for (const char* name : {"wireframe", "valences", "angles", "loops", "symmetry", "landmarks", "regions",
                           "uv", "stretch", "smooth"}) {
    const auto picture = folder / "pictures" / (std::string(name) + ".png");
    EXPECT_TRUE(std::filesystem::is_regular_file(picture)) << picture;
  }
}

TEST(TemplateCommand, SaysInOneLineWhatFallsShort) {
  test::TempFolder folder;
  std::filesystem::copy(kHead / "head.obj", folder / "head.obj");
  std::string notes = read_text(kHead / "head.json");
  const std::string mark = "\"chin\"";
  notes.replace(notes.find(mark), mark.size(), "\"beard\"");
  write_text(folder / "head.json", notes);
  const ProgramRun run = run_template({"check", (folder / "head.obj").string()});
  EXPECT_EQ(run.exit_code, kExitBadInput);
  EXPECT_TRUE(has(run.err, "missing landmarks of the usual 68: chin, should be none")) << run.err;
  EXPECT_TRUE(has(run.out, "SHORT"));
  const ProgramRun json = run_template({"check", (folder / "head.obj").string(), "--json"});
  EXPECT_TRUE(
      has(json.out, R"("what":"missing landmarks of the usual 68","value":"chin","bar":"none","ok":false)"))
      << json.out;
  EXPECT_TRUE(json.out.ends_with("{\"type\":\"exit\",\"code\":4}\n")) << json.out;
}

TEST(TemplateCommand, RefusesABadLayoutWithItsLine) {
  test::TempFolder folder;
  const auto layout = (folder / "layout").string(), output = (folder / "out").string();
  write_text(layout, "point a 0.5 0\ncurve k a b\n");
  ProgramRun run = run_template({"build", layout, "--head", kHead.string(), "-o", output});
  EXPECT_EQ(run.exit_code, kExitBadInput);
  EXPECT_TRUE(has(run.err, "layout: no point 'b' (line 2)")) << run.err;
  write_text(layout,
             "point a 0.5 0\npoint b 0.5 1\npoint c 0 1\npoint d 0 0\ncurve one a c\ncurve two b d\n");
  run = run_template({"build", layout, "--head", kHead.string(), "-o", output});
  EXPECT_EQ(run.exit_code, kExitBadInput);
  EXPECT_TRUE(has(run.err, "curve 'two' (line 6) crosses another curve")) << run.err;
  EXPECT_FALSE(std::filesystem::exists(output));
  EXPECT_EQ(run_template({"build", layout, "-o", output}).exit_code, kExitUsage);
}

TEST(TemplateCommand, AveragesOnlyWhatWasFitted) {
  test::TempFolder folder;
  const std::string store = (folder / "store").string(), output = (folder / "out").string();
  EXPECT_EQ(run_template({"average", "--store", store, "-o", output}).exit_code, kExitNoStore);
  EXPECT_FALSE(std::filesystem::exists(output));
}

}  // namespace
}  // namespace phiz
