#include "store/store.h"

#include <gtest/gtest.h>

#include "store/checkpoint.h"
#include "store/error.h"
#include "store/verify.h"
#include "tests/store/memory_file_system.h"
#include "tests/support/random.h"
#include "tests/support/temp_folder.h"

namespace phiz {
namespace {

CommitRequest example_request(const std::string& stage, std::map<std::string, std::string> outputs) {
  CommitRequest request;
  request.result.key_text.add("stage", "name", stage);
  request.result.key_text.add("input", "scan", compute_digest("scan").hex());
  request.result.run = {1.5, 1000, "host", "0.1", "no result yet"};
  request.outputs = std::move(outputs);
  return request;
}

template <class Call>
StoreFault fault_of(const Call& call) {
  try {
    call();
  } catch (const StoreError& error) {
    return error.fault();
  }
  ADD_FAILURE() << "nothing was thrown";
  return StoreFault::kIo;
}

class StoreTest : public ::testing::Test {
 protected:
  test::MemoryFileSystem disk_;
  Store store_ = Store::open_or_create(disk_, "/disk/store");
};

TEST_F(StoreTest, CommittedOutputsReadBackAndTheResultIsDone) {
  const auto outcome = store_.commit(example_request("ingest", {{"a.vdb", "bytes a"}, {"b.json", "{}"}}));
  const auto done = store_.find_done_result(outcome.result.key());
  ASSERT_TRUE(done);
  EXPECT_EQ(store_.read_object(done->outputs.at("a.vdb").digest), "bytes a");
  EXPECT_EQ(done->outputs.at("b.json").size_bytes, 2u);
  EXPECT_EQ(done->run.reason, "no result yet");
  EXPECT_EQ(done->stage(), "ingest");
  EXPECT_EQ(store_.list_objects().size(), 2u);
  EXPECT_EQ(store_.list_results(), std::vector{outcome.result.key()});
}

TEST_F(StoreTest, PutOfExistingContentWritesNothing) {
  store_.commit(example_request("ingest", {{"a", "same"}}));
  const auto before = disk_.files_created();
  DurableWriter writer(disk_);
  store_.put_object(writer, "same");
  writer.publish();
  EXPECT_EQ(disk_.files_created(), before);
}

TEST_F(StoreTest, CommittingTheSameAgainWritesNothing) {
  CommitRequest request = example_request("ingest", {{"a", "same"}});
  request.subject = SubjectRecord{"dev00", "/x.ply", compute_digest("scan"), 4, {}, {}};
  store_.commit(request);
  const auto before = disk_.files_created();
  EXPECT_FALSE(store_.commit(request).differed);
  EXPECT_EQ(disk_.files_created(), before);
}

TEST_F(StoreTest, AFinishedResultIsKeptWhenTheSameKeyGivesOtherBytes) {
  store_.commit(example_request("ingest", {{"a", "first"}}));
  const auto outcome = store_.commit(example_request("ingest", {{"a", "second"}}));
  EXPECT_TRUE(outcome.differed);
  EXPECT_EQ(store_.read_object(outcome.result.outputs.at("a").digest), "first");
}

TEST_F(StoreTest, AResultWithoutItsObjectIsNotDoneAndCanBeCommittedAgain) {
  const auto request = example_request("ingest", {{"a", "bytes"}});
  const auto outcome = store_.commit(request);
  disk_.remove_file(store_.layout().object(outcome.result.outputs.at("a").digest));
  EXPECT_FALSE(store_.find_done_result(outcome.result.key()));
  store_.commit(request);
  EXPECT_TRUE(store_.find_done_result(outcome.result.key()));
}

TEST_F(StoreTest, ADamagedObjectIsNeverDeliveredAndHealsWhenComputedAnew) {
  const auto request = example_request("ingest", {{"a", "precious bytes"}});
  const auto outcome = store_.commit(request);
  const Digest digest = outcome.result.outputs.at("a").digest;
  disk_.flip_bit(store_.layout().object(digest), 13);
  EXPECT_EQ(fault_of([&] { store_.read_object(digest); }), StoreFault::kDamaged);
  EXPECT_EQ(disk_.list_folder(store_.layout().damaged()).size(), 1u);
  EXPECT_FALSE(store_.find_done_result(outcome.result.key()));
  store_.commit(request);
  EXPECT_EQ(store_.read_object(digest), "precious bytes");
}

TEST_F(StoreTest, PuttingOverADamagedObjectHealsIt) {
  const auto request = example_request("ingest", {{"a", "precious bytes"}});
  const Digest digest = store_.commit(request).result.outputs.at("a").digest;
  disk_.flip_bit(store_.layout().object(digest), 13);
  store_.commit(request);
  EXPECT_EQ(store_.read_object(digest), "precious bytes");
}

TEST_F(StoreTest, ADamagedResultFileIsSetAsideAndCountsAsNone) {
  const auto outcome = store_.commit(example_request("ingest", {{"a", "bytes"}}));
  disk_.flip_bit(store_.layout().result(outcome.result.key()), 100);
  EXPECT_FALSE(store_.find_result(outcome.result.key()));
  EXPECT_EQ(disk_.list_folder(store_.layout().damaged()).size(), 1u);
}

TEST_F(StoreTest, VerifyFindsOneFlippedBitAnywhere) {
  CommitRequest request = example_request("ingest", {{"a", "bytes of a"}, {"b", "other bytes"}});
  request.subject = SubjectRecord{"dev00", "/x.ply", compute_digest("scan"), 4, {}, {}};
  store_.commit(request);
  ASSERT_TRUE(verify_store(store_).ok());
  for (const auto& file : disk_.list_all_files()) {
    if (file == store_.layout().marker()) continue;  // open() checks it
    const std::uint64_t bits = 8 * disk_.find_status(file)->size_bytes;
    for (int trial = 0; trial < 10; ++trial) {
      const std::uint64_t bit = test::random().below(bits);
      disk_.flip_bit(file, bit);
      const VerifyReport report = verify_store(store_);
      EXPECT_FALSE(report.ok()) << file << " bit " << bit;
      ASSERT_FALSE(disk_.find_status(file)) << "should be set aside";
      store_.commit(request);
      EXPECT_TRUE(verify_store(store_).ok()) << "computing anew heals";
    }
  }
}

TEST_F(StoreTest, VerifyNamesTheResultsThatUsedADamagedObject) {
  const auto outcome = store_.commit(example_request("ingest", {{"cloud.vdb", "bytes"}}));
  disk_.flip_bit(store_.layout().object(outcome.result.outputs.at("cloud.vdb").digest), 0);
  const VerifyReport report = verify_store(store_);
  ASSERT_EQ(report.damages.size(), 1u);
  EXPECT_EQ(report.damages[0].used_by,
            std::vector<std::string>{"ingest " + outcome.result.key().hex() + " cloud.vdb"});
  EXPECT_EQ(verify_store(store_).damages.at(0).cause, "it is missing");
}

TEST_F(StoreTest, FoldersThatAreNoStoreAreRefused) {
  disk_.make_folders("/home/photos");
  disk_.create_file("/home/photos/cat.png", {}, FileSystem::Mode::kWritable);
  EXPECT_EQ(fault_of([&] { Store::open_or_create(disk_, "/home/photos"); }), StoreFault::kNoStore);
  EXPECT_EQ(fault_of([&] { Store::open(disk_, "/home"); }), StoreFault::kNoStore);
  EXPECT_EQ(fault_of([&] { Store::open(disk_, "/nowhere"); }), StoreFault::kNoStore);
  EXPECT_FALSE(disk_.find_status("/home/photos/objects"));
}

TEST_F(StoreTest, ADamagedMarkerIsSaidToBeDamaged) {
  disk_.flip_bit(store_.layout().marker(), 30);
  EXPECT_EQ(fault_of([&] { Store::open(disk_, "/disk/store"); }), StoreFault::kDamaged);
}

TEST_F(StoreTest, SubjectsAreListedSortedAndReadBack) {
  for (const char* name : {"b", "a-1", "a.2"}) {
    store_.save_subject({name, "/x.ply", compute_digest("scan"), 4, {}, {}});
  }
  EXPECT_EQ(store_.list_subjects(), (std::vector<std::string>{"a-1", "a.2", "b"}));
  EXPECT_EQ(store_.find_subject("b")->name, "b");
  EXPECT_FALSE(store_.find_subject("c"));
  EXPECT_EQ(fault_of([&] { store_.find_subject("../b"); }), StoreFault::kInvalidName);
}

TEST_F(StoreTest, CheckpointGivesTheLastWholeState) {
  const Checkpoint checkpoint(store_, compute_digest("key"));
  EXPECT_FALSE(checkpoint.load());
  const std::string first = "state 1", second("state\0two", 9);
  checkpoint.save(std::as_bytes(std::span(first)));
  checkpoint.save(std::as_bytes(std::span(second)));
  EXPECT_EQ(checkpoint.load(), second);
  disk_.flip_bit(store_.layout().checkpoint(compute_digest("key")) / "state", 700);
  EXPECT_FALSE(checkpoint.load()) << "a damaged one counts as none";
  checkpoint.save(std::as_bytes(std::span(second)));
  checkpoint.remove();
  EXPECT_FALSE(checkpoint.load());
  EXPECT_TRUE(disk_.list_folder(store_.layout().checkpoints()).empty());
}

TEST(StoreOnDisk, TheSameCallsWorkOnTheRealDisk) {
  const test::TempFolder folder;
  const Store store = Store::open_or_create(real_file_system(), folder / "deep/store");
  const auto request = example_request("ingest", {{"a", std::string(1 << 20, 'x')}, {"b", ""}});
  const auto outcome = store.commit(request);
  EXPECT_EQ(store.read_object(outcome.result.outputs.at("a").digest), std::string(1 << 20, 'x'));
  EXPECT_EQ(store.read_object(outcome.result.outputs.at("b").digest), "");
  const auto permissions =
      std::filesystem::status(store.layout().object(outcome.result.outputs.at("a").digest)).permissions();
  EXPECT_EQ(permissions & std::filesystem::perms(0222), std::filesystem::perms::none)
      << "objects are read-only";
  EXPECT_TRUE(verify_store(Store::open(real_file_system(), folder / "deep/store")).ok());
  EXPECT_EQ(fault_of([&] { real_file_system().read_file(folder / "none"); }), StoreFault::kMissing);
  EXPECT_EQ(fault_of([&] { real_file_system().read_file(folder.path()); }), StoreFault::kIo);
  EXPECT_TRUE(real_file_system().create_exclusively(folder / "x", {}));
  EXPECT_FALSE(real_file_system().create_exclusively(folder / "x", {}));
}

}  // namespace
}  // namespace phiz
