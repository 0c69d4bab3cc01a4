#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "formats/scan_file.h"
#include "tests/e2e/subject.h"
#include "tests/support/temp_folder.h"

namespace phiz::test {
namespace {

TEST(Fit, FinishedWorkIsRecognisedAtOnce) {
  const FittedSubject subject = fitted_subject();
  const std::string before = list_digests(subject.store);
  const ProgramRun again = run_phiz(subject.store, {"fit", subject.scan.string()});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.out.find("nothing to do"), std::string::npos) << again.out;
  EXPECT_LT(again.seconds, 0.5);
  EXPECT_EQ(list_digests(subject.store), before);
}

TEST(Fit, TellsPeopleOnStderrAndProgramsOnStdout) {
  const FittedSubject subject = fitted_subject();
  const ProgramRun run = run_phiz(subject.store, {"fit", subject.scan.string(), "--json"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_TRUE(run.err.empty()) << run.err;
  EXPECT_EQ(run.out.find("{\"type\":\"exit\",\"code\":0}\n") + 25, run.out.size()) << run.out;
  EXPECT_NE(run.out.find("\"scan_from_head\""), std::string::npos);
}

TEST(Fit, DryRunChangesNothing) {
  const FittedSubject subject = fitted_subject();
  const TempFolder folder;
  const ProgramRun run = run_phiz(folder / "store", {"fit", subject.scan.string(), "--dry-run"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "store"));
}

/// "mean_mm" of the first line of `phiz evaluate --json` for a measure and no group.
double find_mean(const std::string& lines, const std::string& measure) {
  std::smatch match;
  const std::regex figure("\"measure\":\"" + measure + "\",\"group\":\"\",[^}]*\"mean_mm\":([0-9.e+-]+)");
  return std::regex_search(lines, match, figure) ? std::stod(match[1]) : std::nan("");
}

TEST(Fit, ReachesTheTruth) {
  const FittedSubject subject = fitted_subject();
  const ProgramRun run =
      run_phiz(subject.store, {"evaluate", subject.name, "--truth", subject.truth.string(), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_LT(find_mean(run.out, "seen truth to fitted"), 0.3) << run.out;
  EXPECT_LT(find_mean(run.out, "cloud to fitted"), 1.1 * find_mean(run.out, "cloud to truth")) << run.out;
}

TEST(Status, NamesTheSubjectAndItsState) {
  const FittedSubject subject = fitted_subject();
  const ProgramRun run = run_phiz(subject.store, {"status"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(std::regex_search(run.out, std::regex(subject.name + " +5/5 +done"))) << run.out;
  EXPECT_EQ(run_phiz(subject.store, {"status", "nobody"}).exit_code, 2);
}

TEST(Why, NamesTheParameterThatChanged) {
  const TempFolder folder;
  copy_store(folder / "store");
  const FittedSubject subject = fitted_subject();
  const ProgramRun changed = run_phiz(folder / "store", {"fit", subject.scan.string(), "--levels", "2"});
  ASSERT_EQ(changed.exit_code, 0) << changed.err;
  EXPECT_NE(changed.out.find("1 of 5 stages computed"), std::string::npos) << changed.out;
  const ProgramRun why = run_phiz(folder / "store", {"why", subject.name, "subdivide"});
  EXPECT_EQ(why.exit_code, 0) << why.err;
  EXPECT_NE(why.out.find("levels: 4 -> 2"), std::string::npos) << why.out;
}

TEST(Explain, ShowsEveryParameterWithItsDefault) {
  const FittedSubject subject = fitted_subject();
  const ProgramRun run = run_phiz(subject.store, {"explain", "subdivide"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("subdivide.levels = 4"), std::string::npos) << run.out;
  EXPECT_EQ(run_phiz(subject.store, {"explain", "nothing"}).exit_code, 2);
}

TEST(Store, VerifiesClean) {
  const FittedSubject subject = fitted_subject();
  const ProgramRun run = run_phiz(subject.store, {"store", "verify"});
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
}

TEST(Store, DamageIsFoundNamedAndMended) {
  const TempFolder folder;
  copy_store(folder / "store");
  const FittedSubject subject = fitted_subject();
  const ProgramRun path = run_phiz(folder / "store", {"store", "path", subject.name + "/subdivide/head.glb"});
  ASSERT_EQ(path.exit_code, 0) << path.err;
  const std::filesystem::path object = path.out.substr(0, path.out.find('\n'));
  const std::string whole = read_bytes(object), digests = list_digests(folder / "store");
  std::string damaged = whole;
  damaged[damaged.size() / 2] ^= 0x40;
  std::filesystem::permissions(object, std::filesystem::perms::owner_all);
  write_text(object, damaged);
  const ProgramRun verify = run_phiz(folder / "store", {"store", "verify"});
  EXPECT_EQ(verify.exit_code, 12) << verify.out;
  EXPECT_NE(verify.out.find("used by subdivide"), std::string::npos) << verify.out;
  EXPECT_EQ(run_phiz(folder / "store", {"fit", subject.scan.string()}).exit_code, 0);
  EXPECT_EQ(read_bytes(object), whole);
  EXPECT_EQ(list_digests(folder / "store"), digests);
  EXPECT_EQ(run_phiz(folder / "store", {"store", "verify"}).exit_code, 0);
}

TEST(Views, AreMadeOnceAndLeaveAsPictures) {
  const TempFolder folder;
  copy_store(folder / "store");
  const FittedSubject subject = fitted_subject();
  const std::vector<std::string> export_view = {"export",    subject.name, "--view",
                                                "subdivide", "-o",         (folder / "head.png").string()};
  EXPECT_EQ(run_phiz(folder / "store", export_view).exit_code, 2) << "there are none yet";
  const ProgramRun made = run_phiz(folder / "store", {"fit", subject.scan.string(), "--views"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_NE(made.out.find("1 of 6 stages computed"), std::string::npos) << made.out;
  const ProgramRun again = run_phiz(folder / "store", {"fit", subject.scan.string(), "--views"});
  EXPECT_NE(again.out.find("nothing to do"), std::string::npos) << again.out;
  for (const char* view : {"ingest", "align", "fit_local", "fit_global", "subdivide", "closeups"}) {
    const std::string file = (folder / (std::string(view) + ".png")).string();
    const ProgramRun run = run_phiz(folder / "store", {"export", subject.name, "--view", view, "-o", file});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(read_bytes(file).substr(1, 3), "PNG");
  }
}

class Export : public testing::TestWithParam<const char*> {};

TEST_P(Export, WritesTheSameFileTwice) {
  const FittedSubject subject = fitted_subject();
  const TempFolder folder;
  const std::filesystem::path first = folder / (std::string("a.") + GetParam());
  const std::filesystem::path second = folder / (std::string("b.") + GetParam());
  for (const auto& file : {first, second}) {
    const ProgramRun run = run_phiz(subject.store, {"export", subject.name, "-o", file.string()});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  EXPECT_GT(read_bytes(first).size(), 1000u);
  EXPECT_EQ(read_bytes(first), read_bytes(second));
}

INSTANTIATE_TEST_SUITE_P(Formats, Export, testing::Values("glb", "obj", "ply", "drc", "vdb", "png"),
                         [](const auto& case_info) { return std::string(case_info.param); });

TEST(Export, LevelsKeepTheirVerticesInPlace) {
  const FittedSubject subject = fitted_subject();
  const TempFolder folder;
  std::vector<ScanFile> levels;
  for (const char* level : {"2", "3"}) {
    const std::filesystem::path file = folder / (std::string(level) + ".ply");
    ASSERT_EQ(
        run_phiz(subject.store, {"export", subject.name, "-o", file.string(), "--level", level}).exit_code,
        0);
    levels.push_back(read_scan_file(file));
  }
  ASSERT_LT(levels[0].points.size(), levels[1].points.size());
  for (std::size_t i = 0; i < levels[0].points.size(); ++i) {
    ASSERT_EQ(levels[0].points.positions[i], levels[1].points.positions[i]) << "vertex " << i;
  }
}

TEST(Export, RefusesWhatItCannotWrite) {
  const FittedSubject subject = fitted_subject();
  const TempFolder folder;
  for (const char* file : {"head.doc", "no/such/folder/head.glb", "head"}) {
    const ProgramRun run = run_phiz(subject.store, {"export", subject.name, "-o", (folder / file).string()});
    EXPECT_EQ(run.exit_code, 2) << file << run.err;
    EXPECT_EQ(count_lines(run.err, "error:"), 1) << run.err;
  }
}

}  // namespace
}  // namespace phiz::test
