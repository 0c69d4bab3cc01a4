#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "tests/e2e/subject.h"
#include "tests/support/temp_folder.h"

namespace phiz::test {
namespace {

ProgramRun adapt(std::vector<std::string> more) {
  std::vector<std::string> words = {"adapt", fitted_subject().name};
  words.insert(words.end(), more.begin(), more.end());
  return run_phiz(fitted_subject().store, words);
}

int count_faces(const std::filesystem::path& obj) {
  return count_lines(read_bytes(obj), "f ");
}

TEST(Adapt, EveryCriterionWritesEveryFormat) {
  const TempFolder folder;
  for (const std::string criterion : {"uniform", "normals", "contour", "order"}) {
    for (const std::string ending : {".obj", ".ply", ".glb"}) {
      const std::string file = (folder / (criterion + ending)).string();
      const ProgramRun run =
          adapt({"--criterion", criterion, "--tolerance", "4", "--budget", "900", "-o", file});
      ASSERT_EQ(run.exit_code, 0) << run.err;
      EXPECT_GT(std::filesystem::file_size(file), 1000u);
    }
  }
  EXPECT_EQ(count_faces(folder / "uniform.obj"), 195 * 8) << "three levels over the authored base";
}

TEST(Adapt, SameCommandSameBytesAtAnyThreadCount) {
  const TempFolder folder;
  const std::string one = (folder / "one.ply").string(), two = (folder / "two.ply").string();
  ASSERT_EQ(adapt({"--tolerance", "3", "-j", "1", "-o", one}).exit_code, 0);
  ASSERT_EQ(adapt({"--tolerance", "3", "-j", "2", "-o", two}).exit_code, 0);
  EXPECT_EQ(read_bytes(one), read_bytes(two));
}

TEST(Adapt, ATighterToleranceNeedsMoreAndTheBudgetHolds) {
  const TempFolder folder;
  const auto faces = [&](std::vector<std::string> words) {
    words.insert(words.end(), {"-o", (folder / "mesh.obj").string()});
    const ProgramRun run = adapt(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return count_faces(folder / "mesh.obj");
  };
  const int coarse = faces({"--tolerance", "6"}), fine = faces({"--tolerance", "2"});
  EXPECT_GT(fine, 2 * coarse);
  EXPECT_LT(faces({"--criterion", "order", "--budget", "500"}), 2 * 510);
  EXPECT_GT(faces({"--base", "head", "--tolerance", "6"}), coarse);
}

TEST(Adapt, FollowsAMotionAndSaysWhatChanged) {
  const TempFolder folder;
  const std::string rig = (folder / "rig").string();
  ASSERT_EQ(run_phiz(folder / "none", {"fields", "muscles", "--side", "128", "-o", rig}).exit_code, 0);
  write_text(folder / "motion.csv", "time_s,JawOpen\n0,0\n0.1,0.5\n0.2,1\n0.3,1\n");
  const std::string motion = (folder / "motion.csv").string(), changes = (folder / "changes.jsonl").string();
  const ProgramRun run = adapt({"--rig", rig, "--motion", motion, "--animate", "--tolerance", "2",
                                "--changes", changes, "-o", (folder / "last.obj").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(count_lines(run.out, "frame "), 4);
  EXPECT_NE(run.out.find("frame 3: "), std::string::npos);
  EXPECT_NE(run.out.find(", 0 splits, 0 welds"), std::string::npos) << "a frame that does not move";
  EXPECT_EQ(count_lines(read_bytes(changes), "{\"frame\":"), 4);
  write_text(folder / "q.json", "{\"jawOpen\": 1}");
  ASSERT_EQ(adapt({"--rig", rig, "--pose", (folder / "q.json").string(), "--tolerance", "2", "-o",
                   (folder / "posed.obj").string()})
                .exit_code,
            0);
  EXPECT_NE(read_bytes(folder / "posed.obj"), read_bytes(folder / "last.obj"));
}

TEST(Adapt, BadInputIsOneLine) {
  const TempFolder folder;
  const std::string out = (folder / "mesh.obj").string();
  const auto refused = [&](std::vector<std::string> words, int code, const std::string& part) {
    const ProgramRun run = adapt(words);
    EXPECT_EQ(run.exit_code, code) << run.err;
    EXPECT_EQ(count_lines(run.err, "error: "), 1) << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
  };
  refused({"--criterion", "contur", "-o", out}, 2, "contur");
  refused({"-o", (folder / "mesh.stl").string()}, 2, ".stl");
  refused({}, 2, "nothing to write");
  refused({"--pose", "q.json", "-o", out}, 2, "--rig");
  refused({"--eye", "1,2", "-o", out}, 2, "--eye");
  write_text(folder / "base.json", "{\"schema\":\"phiz.base_layout.1\",\"points\":[],\"edges\":[]}");
  refused({"--base", (folder / "base.json").string(), "-o", out}, 4, "corner");
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace phiz::test
