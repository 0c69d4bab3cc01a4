#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "orchestrator/error.h"
#include "store/error.h"
#include "store/lease.h"
#include "store/verify.h"
#include "tests/orchestrator/fake_phiz.h"
#include "tests/store/failing_file_system.h"

namespace phiz {
namespace {

using test::FakePhiz;
using Runs = std::map<std::string, int>;

std::vector<nlohmann::json> parse_lines(const std::string& text) {
  std::vector<nlohmann::json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

nlohmann::json find_line(const std::string& text, const std::string& type) {
  for (const auto& line : parse_lines(text)) {
    if (line["type"] == type) return line;
  }
  ADD_FAILURE() << "no line of type " << type << " in\n" << text;
  return {};
}

TEST(Fit, ComputesEachStageOnceAndThenHasNothingToDo) {
  FakePhiz phiz;
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz"}), 0) << phiz.err;
  EXPECT_EQ(phiz.stages.runs, (Runs{{"read", 1}, {"join", 1}, {"finish", 1}}));
  EXPECT_NE(phiz.out.find("a: 3 of 3 stages computed"), std::string::npos) << phiz.out;
  const auto files = phiz.disk.files_created();
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz"}), 0);
  EXPECT_EQ(phiz.stages.runs, (Runs{{"read", 1}, {"join", 1}, {"finish", 1}}));
  EXPECT_NE(phiz.out.find("a: nothing to do"), std::string::npos) << phiz.out;
  EXPECT_EQ(phiz.disk.files_created(), files) << "finished work writes nothing";
}

TEST(Fit, AStageWithAnOptionRunsOnlyWhereAskedForAndOnce) {
  FakePhiz phiz;
  phiz.run({"fit", "/scans/a.xyz"});
  EXPECT_EQ(phiz.stages.runs.count("look"), 0u);
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--look"}), 0) << phiz.err;
  EXPECT_EQ(phiz.stages.runs, (Runs{{"read", 1}, {"join", 1}, {"finish", 1}, {"look", 1}}));
  EXPECT_NE(phiz.out.find("a: 1 of 4 stages computed"), std::string::npos) << phiz.out;
  const auto files = phiz.disk.files_created();
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--look"}), 0);
  EXPECT_NE(phiz.out.find("a: nothing to do"), std::string::npos) << phiz.out;
  EXPECT_EQ(phiz.disk.files_created(), files);
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--until", "look"}), 0);
  EXPECT_EQ(phiz.stages.runs["look"], 1);
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--look", "--until", "join"}), 2);
}

TEST(Fit, OnlyWhatDependsOnAChangeIsComputedAgain) {
  FakePhiz phiz;
  phiz.run({"fit", "/scans/a.xyz"});
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--set", "join.weight=0.25", "-v"}), 0);
  EXPECT_EQ(phiz.stages.runs, (Runs{{"read", 1}, {"join", 2}, {"finish", 1}}))
      << "join made the same bytes, so finish is kept";
  EXPECT_NE(phiz.err.find("join: parameter weight: 0.5 -> 0.25"), std::string::npos) << phiz.err;
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--set", "read.loud=yes"}), 0);
  EXPECT_EQ(phiz.stages.runs, (Runs{{"read", 2}, {"join", 3}, {"finish", 2}}));
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz"}), 0);
  EXPECT_EQ(phiz.stages.runs, (Runs{{"read", 2}, {"join", 3}, {"finish", 2}}))
      << "going back finds what was there";
}

TEST(Fit, ANewTemplateOrScanIsNoticedByItsBytesAlone) {
  FakePhiz phiz;
  phiz.run({"fit", "/scans/a.xyz"});
  phiz.add_file("/elsewhere/a.xyz", "some words of a scan");
  EXPECT_EQ(phiz.run({"fit", "/elsewhere/a.xyz"}), 0);
  EXPECT_EQ(phiz.stages.runs["read"], 1) << "paths are not part of the key";
  phiz.add_file("/head/head.json", "{ }");
  EXPECT_EQ(phiz.run({"fit", "/elsewhere/a.xyz"}), 0);
  EXPECT_EQ(phiz.stages.runs, (Runs{{"read", 1}, {"join", 1}, {"finish", 2}}));
  phiz.add_file("/elsewhere/a.xyz", "other words");
  EXPECT_EQ(phiz.run({"fit", "/elsewhere/a.xyz"}), 0);
  EXPECT_EQ(phiz.stages.runs, (Runs{{"read", 2}, {"join", 2}, {"finish", 3}}));
}

TEST(Fit, TheGenericHeadsFilesAreKeptAsObjects) {
  FakePhiz phiz;
  phiz.run({"fit", "/scans/a.xyz"});
  EXPECT_EQ(phiz.open_store().read_object(compute_digest("v 0 0 0\n")), "v 0 0 0\n");
  EXPECT_EQ(phiz.open_store().read_object(compute_digest("{}")), "{}");
}

TEST(Fit, JsonLinesEndInTheExitCodeAndCarryTheTransform) {
  FakePhiz phiz;
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--json"}), 0);
    const auto lines = parse_lines(phiz.out);
    EXPECT_EQ(phiz.out.substr(phiz.out.rfind('\n', phiz.out.size() - 2) + 1),
              "{\"type\":\"exit\",\"code\":0}\n");
    EXPECT_EQ(phiz.err, "");
    const auto subject = find_line(phiz.out, "subject");
    EXPECT_EQ(subject["subject"], "a");
    EXPECT_EQ(subject["scan_from_head"][3], (std::vector{0, 0, 0, 1}));
    EXPECT_EQ(subject["steps"].size(), 3u);
    EXPECT_EQ(subject["steps"][2]["status"], round == 0 ? "computed" : "kept");
  }
  EXPECT_EQ(phiz.run({"fit", "/scans/none.xyz", "--json"}), 4);
  EXPECT_EQ(find_line(phiz.out, "error")["code"], 4);
  EXPECT_EQ(find_line(phiz.out, "exit")["code"], 4);
}

TEST(Fit, FailuresOfOneSubjectDoNotTouchTheOthers) {
  FakePhiz phiz;
  phiz.add_file("/scans/b.xyz", "a bad scan");
  phiz.add_file("/scans/c.xyz", "a good scan");
  EXPECT_EQ(phiz.run({"fit", "/scans/b.xyz", "/scans/a.xyz", "/scans/none.xyz", "/scans/c.xyz"}), 3);
  EXPECT_NE(phiz.err.find("error: read [b]: /scans/b.xyz: a bad word (line 1)\nhint: mend it\n"),
            std::string::npos)
      << phiz.err;
  EXPECT_NE(phiz.err.find("error: [none]: /scans/none.xyz: no such file\n"), std::string::npos) << phiz.err;
  EXPECT_EQ(phiz.stages.runs["finish"], 2);
}

TEST(Fit, TheCodeSaysWhatWentWrong) {
  FakePhiz phiz;
  phiz.add_file("/scans/bad.xyz", "a bad scan");
  phiz.add_file("/scans/blob.xyz", "a blob");
  phiz.add_file("/scans/empty.xyz", "");
  EXPECT_EQ(phiz.run({"fit", "/scans/bad.xyz"}), 4);
  EXPECT_EQ(phiz.run({"fit", "/scans/empty.xyz"}), 4);
  EXPECT_EQ(phiz.run({"fit", "/scans"}), 4);
  EXPECT_EQ(phiz.run({"fit", "/scans/blob.xyz"}), 14);
  EXPECT_NE(phiz.err.find("error: finish [blob]: not a head\nhint: scan a head\n"), std::string::npos)
      << phiz.err;
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--template", "/none.obj"}), 4);
  phiz.stages.fail_at = "join";
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz"}), 1);
  EXPECT_TRUE(verify_store(phiz.open_store()).ok());
}

TEST(Fit, MistakesOnTheCommandLineRunNothing) {
  FakePhiz phiz;
  phiz.add_file("/other/a.xyz", "x");
  const std::vector<std::vector<std::string>> mistakes = {
      {"fit"},
      {"fit", "/scans/a.xyz", "--no-such-option"},
      {"fit", "/scans/a.xyz", "--set", "nonsense"},
      {"fit", "/scans/a.xyz", "--set", "none.x=1"},
      {"fit", "/scans/a.xyz", "--set", "join.none=1"},
      {"fit", "/scans/a.xyz", "--set", "join.steps=many"},
      {"fit", "/scans/a.xyz", "--set", "join.steps=0"},
      {"fit", "/scans/a.xyz", "--set", "join.weight=nan"},
      {"fit", "/scans/a.xyz", "--units", "furlong"},
      {"fit", "/scans/a.xyz", "--until", "none"},
      {"fit", "/scans/a.xyz", "--subject", "../a"},
      {"fit", "/scans/a.xyz", "/other/a.xyz"},
      {"fit", "/scans/a.xyz", "/other/b.xyz", "--subject", "x"},
      {"fit", "/scans/a.xyz", "-j", "0"},
      {"fit", "--list", "/none.csv"},
      {"frobnicate"},
      {},
  };
  for (const auto& arguments : mistakes) {
    EXPECT_EQ(phiz.run(arguments), 2) << ::testing::PrintToString(arguments);
    EXPECT_EQ(phiz.err.substr(0, 7), "error: ") << phiz.err;
    EXPECT_LE(std::count(phiz.err.begin(), phiz.err.end(), '\n'), 2) << phiz.err;
  }
  EXPECT_FALSE(phiz.disk.find_status("/disk/store"));
  EXPECT_TRUE(phiz.stages.runs.empty());
}

TEST(Fit, AListNamesSubjectsScansAndParameters) {
  FakePhiz phiz;
  phiz.add_file("/scans/list.csv",
                "subject,scan,units,join.steps\nfirst,a.xyz,mm,5\n\"second\",/scans/a.xyz,,\n");
  EXPECT_EQ(phiz.run({"fit", "--list", "/scans/list.csv", "-j", "1"}), 0) << phiz.err;
  EXPECT_EQ(phiz.open_store().list_subjects(), (std::vector<std::string>{"first", "second"}));
  EXPECT_EQ(phiz.stages.runs["join"], 2);
  phiz.add_file("/scans/list.csv", "subject,scan,colour\nx,a.xyz,red\n");
  EXPECT_EQ(phiz.run({"fit", "--list", "/scans/list.csv"}), 2);
}

TEST(Fit, ADryRunChangesNothingAndSaysWhy) {
  FakePhiz phiz;
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "-n"}), 0);
  EXPECT_FALSE(phiz.disk.find_status("/disk/store"));
  EXPECT_NE(phiz.out.find("a: 3 of 3 stages would be computed"), std::string::npos) << phiz.out;
  phiz.run({"fit", "/scans/a.xyz"});
  const auto files = phiz.disk.files_created();
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "-n", "--set", "join.steps=4"}), 0);
  EXPECT_NE(phiz.err.find("a: join: would be computed: parameter steps: 3 -> 4"), std::string::npos)
      << phiz.err;
  EXPECT_NE(phiz.out.find("a: 2 of 3 stages would be computed"), std::string::npos) << phiz.out;
  EXPECT_EQ(phiz.disk.files_created(), files);
}

TEST(Fit, UntilStopsAfterAStage) {
  FakePhiz phiz;
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--until", "join"}), 0);
  EXPECT_EQ(phiz.stages.runs, (Runs{{"read", 1}, {"join", 1}}));
}

TEST(Fit, AnInterruptedStageContinuesFromItsCheckpointToTheSameBytes) {
  FakePhiz undisturbed;
  undisturbed.run({"fit", "/scans/a.xyz", "--set", "join.steps=8"});

  FakePhiz phiz;
  phiz.stages.stop_at_step = 5;
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--set", "join.steps=8"}), 130);
  EXPECT_NE(phiz.err.find("hint: run the same command to continue"), std::string::npos) << phiz.err;
  phiz.stages.stop_at_step = -1;
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--set", "join.steps=8"}), 0) << phiz.err;
  EXPECT_EQ(phiz.stages.first_step, 5);
  EXPECT_EQ(phiz.stages.runs["read"], 1);
  EXPECT_EQ(phiz.digest_of("a", "finish", "head.glb"), undisturbed.digest_of("a", "finish", "head.glb"));
  EXPECT_TRUE(phiz.disk.list_folder("/disk/store/checkpoints").empty()) << "a finished stage needs none";
}

TEST(Fit, ADamagedObjectIsComputedAnewInTheSameRun) {
  FakePhiz phiz;
  phiz.run({"fit", "/scans/a.xyz"});
  const Digest words = phiz.digest_of("a", "read", "words.txt");
  const Digest head = phiz.digest_of("a", "finish", "head.glb");
  phiz.disk.flip_bit(phiz.open_store().layout().object(words), 3);
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--set", "join.weight=1"}), 0) << phiz.err;
  EXPECT_NE(phiz.err.find("warning: join [a]: object " + words.hex()), std::string::npos) << phiz.err;
  EXPECT_EQ(phiz.stages.runs["read"], 2);
  EXPECT_EQ(phiz.open_store().read_object(words), "some\nwords\nof\na\nscan\n");
  EXPECT_EQ(phiz.digest_of("a", "finish", "head.glb"), head);
}

TEST(Fit, ManySubjectsGiveTheSameBytesAtAnyThreadCount) {
  const auto fit_all = [](FakePhiz& phiz, const std::string& threads) {
    std::vector<std::string> arguments = {"fit", "-j", threads};
    for (int i = 0; i < 12; ++i) {
      const std::string path = "/scans/s" + std::to_string(i) + ".xyz";
      phiz.add_file(path,
                    "scan number " + std::to_string(i / 2));  // pairs share their bytes, and their results
      arguments.push_back(path);
    }
    EXPECT_EQ(phiz.run(arguments), 0) << phiz.err;
  };
  FakePhiz one, four;
  fit_all(one, "1");
  fit_all(four, "4");
  EXPECT_EQ(one.open_store().list_objects(), four.open_store().list_objects());
  EXPECT_EQ(one.open_store().list_results(), four.open_store().list_results());
  EXPECT_EQ(four.stages.runs["read"], 6) << "equal work is done once, whoever is first";
  EXPECT_EQ(four.stages.runs["finish"], 6);
}

TEST(Fit, ALivingHolderIsRespectedAndADeadOneIsNot) {
  FakePhiz phiz;
  phiz.run({"fit", "/scans/a.xyz", "--until", "read"});
  const Store store = phiz.open_store();
  phiz.run({"fit", "/scans/a.xyz"});
  const Digest key = store.find_subject("a")->results.at("join");
  phiz.disk.remove_file(store.layout().result(key));

  LeaseTable other(store, real_processes());
  {
    const auto held = other.try_acquire(key);
    EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--no-wait"}), 11);
    EXPECT_NE(phiz.err.find("is computing it now"), std::string::npos) << phiz.err;
  }
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--no-wait"}), 0);
  EXPECT_TRUE(phiz.disk.list_folder("/disk/store/leases").empty());
}

TEST(Fit, TheFrontAnswersFinishedWorkAndLeavesEverythingElseToTheEngine) {
  FakePhiz phiz;
  phiz.is_front = true;
  EXPECT_THROW(phiz.run({"fit", "/scans/a.xyz"}), EngineNeeded);
  EXPECT_THROW(phiz.run({"--help"}), EngineNeeded);
  EXPECT_THROW(phiz.run({"export", "a"}), EngineNeeded);
  phiz.is_front = false;
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz"}), 0);
  phiz.is_front = true;
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz"}), 0);
  EXPECT_NE(phiz.out.find("nothing to do"), std::string::npos);
  EXPECT_THROW(phiz.run({"fit", "/scans/a.xyz", "--set", "join.steps=4"}), EngineNeeded);
}

/// The whole program with a disk that fails at the n-th operation, for every n: it ends with a documented
/// code, the store stays sound, and the same command again ends in the same bytes.
void expect_resume_at_every_operation(test::FailingFileSystem::Failure failure, std::set<int> allowed_codes) {
  FakePhiz undisturbed;
  undisturbed.run({"fit", "/scans/a.xyz"});
  const Digest expected = undisturbed.digest_of("a", "finish", "head.glb");
  for (std::uint64_t n = 1;; ++n) {
    SCOPED_TRACE("failing at operation " + std::to_string(n));
    FakePhiz phiz;
    test::FailingFileSystem failing(phiz.disk, n, failure);
    const int code = phiz.run_on(failing, {"fit", "/scans/a.xyz", "-j", "1"});
    EXPECT_TRUE(allowed_codes.contains(code)) << code << "\n" << phiz.err;
    EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "-j", "1"}), 0) << phiz.err;
    EXPECT_EQ(phiz.digest_of("a", "finish", "head.glb"), expected);
    const VerifyReport report = verify_store(phiz.open_store());
    for (const StoreDamage& damage : report.damages) ADD_FAILURE() << damage.what << ": " << damage.cause;
    if (!failing.has_failed() || ::testing::Test::HasFailure()) break;
  }
}

TEST(FitFaults, OneFailedOperationIsSurvived) {
  expect_resume_at_every_operation(test::FailingFileSystem::Failure::kOnce, {0, 1, 4});
}

TEST(FitFaults, AFullDiskIsSaidAndSurvived) {
  expect_resume_at_every_operation(test::FailingFileSystem::Failure::kFull, {0, 13});
}

TEST(FitFaults, ADiskThatGoesAwayIsSurvived) {
  expect_resume_at_every_operation(test::FailingFileSystem::Failure::kStopped, {0, 1, 4});
}

}  // namespace
}  // namespace phiz
