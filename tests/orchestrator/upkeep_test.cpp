// The commands that keep a store in order, and runs of many subjects.

#include <gtest/gtest.h>

#include "orchestrator/error.h"
#include "orchestrator/quantity.h"
#include "store/error.h"
#include "store/verify.h"
#include "tests/orchestrator/fake_phiz.h"

namespace phiz {
namespace {

using test::FakePhiz;

TEST(Quantity, ReadsBytesAndDurations) {
  EXPECT_EQ(parse_bytes("0", "x"), 0u);
  EXPECT_EQ(parse_bytes("1500", "x"), 1500u);
  EXPECT_EQ(parse_bytes("4k", "x"), 4096u);
  EXPECT_EQ(parse_bytes("1.5GiB", "x"), 3u << 29);
  EXPECT_EQ(parse_bytes("2MB", "x"), 2u << 20);
  EXPECT_EQ(parse_duration("90", "x"), 90);
  EXPECT_EQ(parse_duration("2h", "x"), 7200);
  EXPECT_EQ(parse_duration("30d", "x"), 30 * 86400);
  for (const std::string bad : {"", "-1", "nan", "4X", "k", "1 G", "1e30T"}) {
    EXPECT_THROW(parse_bytes(bad, "--max-size"), UsageError) << bad;
    EXPECT_THROW(parse_duration(bad, "--older-than"), UsageError) << bad;
  }
}

/// One flipped bit in any file of the store: found, and mended with the parameters it was made with.
TEST(Verify, ARepairComputesAnewWhatAnyFlippedBitHasSpoilt) {
  FakePhiz whole;
  whole.run({"fit", "/scans/a.xyz", "--set", "join.weight=2", "--look"});
  const Digest head = whole.digest_of("a", "finish", "head.glb");
  for (const auto& file : whole.disk.list_all_files()) {
    const std::string path = file.string();
    if (!path.starts_with("/disk/store/")) continue;
    SCOPED_TRACE(path);
    FakePhiz phiz;
    phiz.run({"fit", "/scans/a.xyz", "--set", "join.weight=2", "--look"});
    phiz.disk.flip_bit(file, 8 * (whole.disk.read_file(file).size() / 2) + 3);
    EXPECT_EQ(phiz.run({"store", "verify"}), 12) << phiz.out;
    EXPECT_EQ(phiz.run({"store", "verify", "--repair"}), 0) << phiz.err;
    EXPECT_EQ(phiz.digest_of("a", "finish", "head.glb"), head);
    EXPECT_TRUE(verify_store(phiz.open_store()).ok());
    const int runs = phiz.stages.runs["join"];
    EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--set", "join.weight=2", "--look"}), 0);
    EXPECT_EQ(phiz.stages.runs["join"], runs) << "the repair was complete";
  }
}

TEST(Gc, RemovesWhatNoSubjectNeedsAndADryRunSaysSo) {
  FakePhiz phiz;
  phiz.run({"fit", "/scans/a.xyz", "--set", "join.steps=5"});
  const Digest former = phiz.digest_of("a", "finish", "head.glb");
  phiz.run({"fit", "/scans/a.xyz"});
  EXPECT_EQ(phiz.run({"store", "gc"}), 0) << phiz.err;
  EXPECT_TRUE(phiz.open_store().find_object_size(former)) << "younger than the default";
  EXPECT_EQ(phiz.run({"store", "gc", "--older-than", "0s", "-n"}), 0);
  EXPECT_NE(phiz.out.find("would remove object " + former.hex()), std::string::npos) << phiz.out;
  EXPECT_TRUE(phiz.open_store().find_object_size(former));
  EXPECT_EQ(phiz.run({"store", "gc", "--older-than", "0s"}), 0);
  EXPECT_FALSE(phiz.open_store().find_object_size(former));
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz"}), 0);
  EXPECT_NE(phiz.out.find("nothing to do"), std::string::npos);
  EXPECT_EQ(phiz.run({"store", "gc", "--max-size", "1Q"}), 2);
  EXPECT_EQ(phiz.run({"store", "stats"}), 0);
  EXPECT_EQ(phiz.run({"store", "unlock"}), 0);
  EXPECT_EQ(phiz.run({"store", "migrate"}), 0);
}

TEST(Pin, KeepsAResultThatNoSubjectNamesAnyMore) {
  FakePhiz phiz;
  phiz.run({"fit", "/scans/a.xyz", "--set", "join.steps=5"});
  const Digest former = phiz.digest_of("a", "finish", "head.glb");
  const std::string key = phiz.open_store().find_subject("a")->results.at("finish").hex();
  EXPECT_EQ(phiz.run({"store", "pin", "a/finish"}), 0) << phiz.err;
  EXPECT_EQ(phiz.run({"store", "pin", "a/none"}), 2);
  EXPECT_EQ(phiz.run({"store", "pin", "b"}), 2);
  EXPECT_EQ(phiz.run({"store", "pin", std::string(64, '0')}), 2);
  phiz.run({"fit", "/scans/a.xyz"});
  EXPECT_EQ(phiz.run({"store", "gc", "--older-than", "0s"}), 0);
  EXPECT_TRUE(phiz.open_store().find_object_size(former));
  EXPECT_EQ(phiz.run({"store", "pin"}), 0);
  EXPECT_EQ(phiz.out, "pinned " + key + " finish\n");
  EXPECT_EQ(phiz.run({"store", "unpin", key, "-n"}), 0);
  EXPECT_EQ(phiz.open_store().list_pins().size(), 1u) << "a dry run";
  EXPECT_EQ(phiz.run({"store", "unpin", key}), 0);
  EXPECT_EQ(phiz.run({"store", "gc", "--older-than", "0s"}), 0);
  EXPECT_FALSE(phiz.open_store().find_object_size(former));
  EXPECT_EQ(phiz.run({"store", "pin", "a"}), 0);
  EXPECT_EQ(phiz.open_store().list_pins().size(), 3u) << "all of a subject's current results";
}

TEST(Pack, CarriesASubjectToAnotherStore) {
  FakePhiz phiz, other;
  phiz.run({"fit", "/scans/a.xyz"});
  EXPECT_EQ(phiz.run({"store", "pack", "a", "-o", "/disk/a.tar"}), 0) << phiz.err;
  EXPECT_EQ(phiz.run({"store", "pack", "none", "-o", "/disk/b.tar"}), 2);
  other.add_file("/disk/a.tar", phiz.disk.read_file("/disk/a.tar"));
  EXPECT_EQ(other.run({"store", "unpack", "/disk/a.tar"}), 0) << other.err;
  EXPECT_EQ(other.run({"fit", "/scans/a.xyz"}), 0);
  EXPECT_NE(other.out.find("a: nothing to do"), std::string::npos) << other.out;
  other.add_file("/disk/a.tar", "nonsense");
  EXPECT_EQ(other.run({"store", "unpack", "/disk/a.tar"}), 4);
  EXPECT_EQ(other.run({"store", "unpack", "/disk/none.tar"}), 2);
}

TEST(Many, FailuresAreListedAtTheEndAndFailFastStops) {
  FakePhiz phiz;
  phiz.add_file("/scans/b.xyz", "a bad scan");
  phiz.add_file("/scans/c.xyz", "a good scan");
  EXPECT_EQ(
      phiz.run({"fit", "/scans/b.xyz", "/scans/a.xyz", "/scans/c.xyz", "--max-memory", "1G", "--keep-going"}),
      3);
  EXPECT_NE(phiz.err.find("1 of 3 subjects failed:\n  b read (code 4): "), std::string::npos) << phiz.err;
  EXPECT_EQ(phiz.run({"log", "b"}), 0);
  EXPECT_NE(phiz.out.find(" b read failed code 4"), std::string::npos) << phiz.out;
  EXPECT_EQ(phiz.run({"fit", "/scans/b.xyz", "/scans/c.xyz", "-j", "1", "--fail-fast"}), 3);
  EXPECT_NE(phiz.err.find("1 of 2 subjects were not started"), std::string::npos) << phiz.err;
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--fail-fast", "--keep-going"}), 2);
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--max-memory", "much"}), 2);
}

TEST(Many, TheWordAfterASettingIsAScan) {
  FakePhiz phiz;
  EXPECT_EQ(phiz.run({"fit", "--set", "join.steps=4", "--set", "join.weight=1", "/scans/a.xyz"}), 0)
      << phiz.err;
}

TEST(Status, SeesWhatWasRemovedBehindItsBackAndOneBadRecordHidesNoOther) {
  FakePhiz phiz;
  phiz.add_file("/scans/b.xyz", "another scan");
  phiz.run({"fit", "/scans/a.xyz", "/scans/b.xyz"});
  const Store store = phiz.open_store();
  EXPECT_EQ(phiz.run({"status"}), 0);
  EXPECT_EQ(phiz.out.find("missing"), std::string::npos) << phiz.out;
  phiz.disk.remove_file(store.layout().object(phiz.digest_of("a", "join", "joined.txt")));
  EXPECT_EQ(phiz.run({"status"}), 0);
  EXPECT_NE(phiz.out.find("join missing"), std::string::npos) << phiz.out;
  phiz.disk.flip_bit(store.layout().subject("a"), 77);
  EXPECT_EQ(phiz.run({"status"}), 0);
  EXPECT_NE(phiz.out.find("record unreadable"), std::string::npos) << phiz.out;
  EXPECT_NE(phiz.out.find("b  "), std::string::npos) << phiz.out;
  EXPECT_EQ(phiz.run({"status", "--watch", "b"}), 0) << "all of it is done";
}

}  // namespace
}  // namespace phiz
