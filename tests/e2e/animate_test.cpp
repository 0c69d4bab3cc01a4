#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "formats/motion.h"
#include "tests/e2e/subject.h"
#include "tests/support/temp_folder.h"

namespace phiz::test {
namespace {

ProgramRun animate(std::vector<std::string> more) {
  more.insert(more.begin(), {"animate", fitted_subject().name});
  return run_phiz(fitted_subject().store, more);
}

Motion read(const std::filesystem::path& file) {
  std::istringstream in(read_bytes(file));
  return read_motion(in);
}

TEST(Animate, AnExpressionBecomesTheSameClipTwice) {
  const TempFolder folder;
  const std::string a = (folder / "a.glb").string(), b = (folder / "b.glb").string();
  const ProgramRun run = animate({"--expression", "smile=0.8,jawOpen=0.2", "--seconds", "0.5", "-o", a});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  ASSERT_EQ(animate({"--expression", "smile=0.8,jawOpen=0.2", "--seconds", "0.5", "-o", b}).exit_code, 0);
  EXPECT_EQ(read_bytes(a), read_bytes(b));
  EXPECT_EQ(read_bytes(a).substr(0, 4), "glTF");
}

TEST(Animate, MusclesAndRigSolveEachOther) {
  const TempFolder folder;
  const std::string rig = (folder / "rig").string(), muscles = (folder / "muscles.csv").string();
  const std::string controls = (folder / "controls.csv").string();
  ASSERT_EQ(run_phiz(folder / "none", {"fields", "muscles", "--side", "128", "-o", rig}).exit_code, 0);
  write_text(folder / "take.csv", "time_s,mouthSmileLeft,mouthSmileRight\n0,0,0\n0.1,0.8,0.8\n");
  ProgramRun run = animate({"--solve", (folder / "take.csv").string(), "--rig", rig, "-o", muscles});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Motion solved = read(muscles);
  const auto smile = std::find(solved.names.begin(), solved.names.end(), "zygomaticMajorLeft");
  ASSERT_NE(smile, solved.names.end());
  EXPECT_GT(solved.frame(1)[smile - solved.names.begin()], 0.2);
  run = animate({"--activations", muscles, "--rig", rig, "-o", controls});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(read(controls).names.size(), 52u);
  EXPECT_EQ(animate({"--activations", controls}).exit_code, 0) << "what comes back plays again";
}

TEST(Animate, BadInputIsOneLine) {
  EXPECT_EQ(animate({}).exit_code, 2);
  EXPECT_EQ(animate({"--expression", "smile=x"}).exit_code, 2);
  EXPECT_EQ(animate({"--expression", "grin=1"}).exit_code, 4);
  EXPECT_EQ(animate({"--expression", "smile", "--level", "9"}).exit_code, 2);
  EXPECT_EQ(animate({"--expression", "smile", "--anatomy", "/nowhere.json"}).exit_code, 4);
}

}  // namespace
}  // namespace phiz::test
