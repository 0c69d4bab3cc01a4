#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "orchestrator/error_table.h"
#include "tests/orchestrator/fake_phiz.h"

namespace phiz {
namespace {

using test::FakePhiz;

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class Commands : public ::testing::Test {
 protected:
  Commands() { EXPECT_EQ(phiz_.run({"fit", "/scans/a.xyz"}), 0) << phiz_.err; }
  FakePhiz phiz_;
};

TEST_F(Commands, StatusTellsDoneStaleAndMissing) {
  EXPECT_EQ(phiz_.run({"status"}), 0);
  EXPECT_TRUE(has(phiz_.out, "a        3/3  done")) << phiz_.out;
  phiz_.run({"fit", "/scans/a.xyz", "--until", "read", "--set", "read.loud=true"});
  phiz_.run({"status", "a"});
  EXPECT_TRUE(has(phiz_.out, "a        1/3  join stale")) << phiz_.out;
  const Store store = phiz_.open_store();
  phiz_.disk.remove_file(store.layout().object(phiz_.digest_of("a", "read", "words.txt")));
  phiz_.run({"status", "a"});
  EXPECT_TRUE(has(phiz_.out, "a        0/3  read missing")) << phiz_.out;
  EXPECT_EQ(phiz_.run({"status", "nobody"}), 2);
}

TEST_F(Commands, StatusCountsAStageWithAnOptionOnceItWasAskedFor) {
  phiz_.run({"fit", "/scans/a.xyz", "--look"});
  phiz_.run({"status", "a"});
  EXPECT_TRUE(has(phiz_.out, "a        4/4  done")) << phiz_.out;
  phiz_.run({"fit", "/scans/a.xyz", "--set", "read.loud=true"});
  phiz_.run({"status", "a"});
  EXPECT_TRUE(has(phiz_.out, "a        3/4  look stale")) << phiz_.out;
}

TEST_F(Commands, WhyNamesTheLineOfTheKeyThatChanged) {
  EXPECT_EQ(phiz_.run({"why", "a", "join"}), 0);
  EXPECT_TRUE(has(phiz_.out, "computed because: no result yet")) << phiz_.out;
  phiz_.run({"fit", "/scans/a.xyz", "--set", "join.steps=4"});
  EXPECT_EQ(phiz_.run({"why", "a", "join"}), 0);
  EXPECT_TRUE(has(phiz_.out, "  parameter steps: 3 -> 4\n")) << phiz_.out;
  EXPECT_EQ(phiz_.run({"why", "a", "finish", "--json"}), 0);
  const auto line = nlohmann::json::parse(phiz_.out.substr(0, phiz_.out.find('\n')));
  EXPECT_EQ(line["differences"].size(), 1u);
  EXPECT_EQ(line["differences"][0]["name"], "joined.txt");
  EXPECT_EQ(phiz_.run({"why", "a", "nostage"}), 2);
}

TEST_F(Commands, ExplainPrintsDefaultsUnitsAndSources) {
  EXPECT_EQ(phiz_.run({"explain", "join"}), 0);
  EXPECT_TRUE(has(phiz_.out, "join.weight = 0.5 mm  (number from 0 to 10)")) << phiz_.out;
  EXPECT_TRUE(has(phiz_.out, "the weight [paper, 4.3]")) << phiz_.out;
  EXPECT_TRUE(has(phiz_.out, "in   words.txt, of read")) << phiz_.out;
  EXPECT_EQ(phiz_.run({"explain"}), 0);
  EXPECT_TRUE(has(phiz_.out, "finish       makes the head")) << phiz_.out;
  EXPECT_EQ(phiz_.run({"explain", "none"}), 2);
  EXPECT_TRUE(has(phiz_.err, "hint: the stages are: read, join, finish")) << phiz_.err;
}

TEST_F(Commands, StoreNamesAndDeliversObjects) {
  EXPECT_EQ(phiz_.run({"store", "cat", "a/words.txt"}), 0);
  EXPECT_EQ(phiz_.out, "some\nwords\nof\na\nscan\n");
  EXPECT_EQ(phiz_.run({"store", "cat", "a/read/words.txt"}), 0);
  EXPECT_EQ(phiz_.run({"store", "cat", phiz_.digest_of("a", "read", "words.txt").hex()}), 0);
  EXPECT_EQ(phiz_.out, "some\nwords\nof\na\nscan\n");
  EXPECT_EQ(phiz_.run({"store", "path", "a/words.txt"}), 0);
  EXPECT_EQ(phiz_.disk.read_file(phiz_.out.substr(0, phiz_.out.size() - 1)), "some\nwords\nof\na\nscan\n");
  EXPECT_EQ(phiz_.run({"store", "ls"}), 0);
  EXPECT_TRUE(has(phiz_.out, phiz_.digest_of("a", "finish", "head.glb").hex())) << phiz_.out;
  EXPECT_TRUE(has(phiz_.out, "a/finish/head.glb")) << phiz_.out;
  EXPECT_EQ(phiz_.run({"store", "cat", "a/none"}), 2);
  EXPECT_EQ(phiz_.run({"store", "cat", "../../etc/passwd"}), 2);
}

TEST_F(Commands, StoreCatNeverDeliversDamagedBytes) {
  const Store store = phiz_.open_store();
  phiz_.disk.flip_bit(store.layout().object(phiz_.digest_of("a", "read", "words.txt")), 0);
  EXPECT_EQ(phiz_.run({"store", "cat", "a/words.txt"}), 12);
  EXPECT_EQ(phiz_.out, "");
}

TEST_F(Commands, VerifyNamesTheDamageAndItsUsersAndFitRepairs) {
  EXPECT_EQ(phiz_.run({"store", "verify"}), 0);
  const Digest head = phiz_.digest_of("a", "finish", "head.glb");
  phiz_.disk.flip_bit(phiz_.open_store().layout().object(head), 5);
  EXPECT_EQ(phiz_.run({"store", "verify"}), 12);
  EXPECT_TRUE(has(phiz_.out, "damaged: object " + head.hex())) << phiz_.out;
  EXPECT_TRUE(has(phiz_.out, "  used by finish ")) << phiz_.out;
  EXPECT_EQ(phiz_.run({"fit", "/scans/a.xyz"}), 0);
  EXPECT_EQ(phiz_.run({"store", "verify"}), 0);
  EXPECT_EQ(phiz_.digest_of("a", "finish", "head.glb"), head);
}

TEST(CommandsWithoutStore, SayThatThereIsNone) {
  FakePhiz phiz;
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"status"}, {"why", "a", "join"}, {"store", "ls"}, {"store", "verify"}}) {
    EXPECT_EQ(phiz.run(arguments), 10) << arguments[0];
    EXPECT_TRUE(has(phiz.err, "no store there\nhint: ")) << phiz.err;
  }
}

TEST(Help, ListsCommandsAndEveryExitCode) {
  FakePhiz phiz;
  EXPECT_EQ(phiz.run({"--help"}), 0);
  for (const ExitCode& exit_code : exit_codes())
    EXPECT_TRUE(has(phiz.out, exit_code.meaning)) << exit_code.meaning;
  for (const char* command : {"fit", "status", "why", "explain", "store"})
    EXPECT_TRUE(has(phiz.out, command));
  EXPECT_EQ(phiz.run({"fit", "--help"}), 0);
  EXPECT_TRUE(has(phiz.out, "--units")) << phiz.out;
  EXPECT_EQ(phiz.run({"--version"}), 0);
  EXPECT_TRUE(has(phiz.out, "phiz ")) << phiz.out;
}

}  // namespace
}  // namespace phiz
