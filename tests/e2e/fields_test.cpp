#include <gtest/gtest.h>

#include <sstream>

#include "tests/e2e/subject.h"
#include "tests/support/temp_folder.h"

namespace phiz::test {
namespace {

const std::string kMotion = "time_s,JawOpen,mouthSmileLeft,HeadYaw\n0,0,0,0.1\n0.1,0.5,1,0.1\n0.2,1,0,0.1\n";

/// A rig on a coarse grid and a motion, in a folder of their own.
struct Files {
  Files() {
    const ProgramRun made = run_phiz(folder / "none", {"fields", "muscles", "--side", "128", "-o", rig()});
    EXPECT_EQ(made.exit_code, 0) << made.err;
    write_text(folder / "motion.csv", kMotion);
  }
  std::string rig() const { return (folder / "rig").string(); }
  ProgramRun retarget(std::vector<std::string> more) const {
    std::vector<std::string> words = {
        "retarget", "--motion",           (folder / "motion.csv").string(), "--rig", rig(),
        "--to",     fitted_subject().name};
    words.insert(words.end(), more.begin(), more.end());
    return run_phiz(fitted_subject().store, words);
  }
  TempFolder folder;
};

std::vector<std::string> lines_of(const std::string& text, const std::string& start) {
  std::vector<std::string> found;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(start)) found.push_back(line);
  }
  return found;
}

TEST(Fields, ListNamesFieldsAndControls) {
  const Files files;
  const ProgramRun list = run_phiz(files.folder / "none", {"fields", "list", files.rig() + ".json"});
  EXPECT_EQ(list.exit_code, 0) << list.err;
  EXPECT_EQ(count_lines(list.out, "control "), 52);
  EXPECT_GE(count_lines(list.out, "field "), 53);
}

TEST(Fields, MusclesMakeTheSameBytesTwice) {
  const Files a, b;
  EXPECT_EQ(read_bytes(a.rig() + ".json"), read_bytes(b.rig() + ".json"));
  EXPECT_EQ(read_bytes(a.rig() + ".exr"), read_bytes(b.rig() + ".exr"));
}

TEST(Retarget, TheNeutralFrameIsTheExportedHead) {
  const Files files;
  const std::string out = (files.folder / "out").string();
  const ProgramRun run = files.retarget({"-o", out, "--format", "obj"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string name = fitted_subject().name, exported = (files.folder / "head.obj").string();
  ASSERT_EQ(run_phiz(fitted_subject().store, {"export", name, "--level", "2", "-o", exported}).exit_code, 0);
  const std::vector<std::string> head = lines_of(read_bytes(exported), "v ");
  EXPECT_EQ(lines_of(read_bytes(out + "/" + name + "/frame_00000.obj"), "v "), head);
  EXPECT_NE(lines_of(read_bytes(out + "/" + name + "/frame_00001.obj"), "v "), head);
}

TEST(Retarget, FinishedSubjectsAreKeptUntilTheMotionChanges) {
  const Files files;
  const std::string out = (files.folder / "out").string(), name = fitted_subject().name;
  ASSERT_EQ(files.retarget({"-o", out}).exit_code, 0);
  const std::string glb = read_bytes(out + "/" + name + ".glb");
  const ProgramRun again = files.retarget({"-o", out});
  EXPECT_NE(again.out.find("kept"), std::string::npos) << again.out;
  EXPECT_EQ(read_bytes(out + "/" + name + ".glb"), glb);
  write_text(files.folder / "motion.csv", kMotion + "0.3,0.2,0.2,0\n");
  EXPECT_EQ(files.retarget({"-o", out}).out.find("kept"), std::string::npos);
  EXPECT_NE(read_bytes(out + "/" + name + ".glb"), glb);
}

TEST(Retarget, BadInputIsOneLineAndNothingIsWritten) {
  const Files files;
  const std::filesystem::path out = files.folder / "out";
  const auto refused = [&](const std::string& part) {
    const ProgramRun run = files.retarget({"-o", out.string()});
    EXPECT_EQ(run.exit_code, 4) << run.err;
    EXPECT_EQ(count_lines(run.err, "error: "), 1) << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
    EXPECT_FALSE(std::filesystem::exists(out));
  };
  write_text(files.folder / "motion.csv", "time_s,jawOpne\n0,1\n");
  refused("jawOpen");
  write_text(files.folder / "motion.csv", "time_s,jawOpen\n0,nan\n");
  refused("line 2, column jawOpen");
  write_text(files.folder / "motion.csv", "jawOpen\n0\n");
  refused("Timecode");
  write_text(files.folder / "motion.csv", kMotion);
  const std::string json = read_bytes(files.rig() + ".json"), exr = read_bytes(files.rig() + ".exr");
  write_text(files.rig() + ".exr", exr.substr(0, exr.size() / 2));
  refused("rig");
  write_text(files.rig() + ".exr", exr);
  std::string looped = json;
  looped.replace(looped.find("\"on\":[\"neutral\"]"), 16, "\"on\":[\"jawOpen\"]");
  write_text(files.rig() + ".json", looped);
  refused("loop");
  std::string strange = json;
  strange.replace(strange.find("\"add_local\""), 11, "\"add_magic\"");
  write_text(files.rig() + ".json", strange);
  refused("add_magic");
}

}  // namespace
}  // namespace phiz::test
