#include "store/collect.h"

#include <gtest/gtest.h>

#include <set>

#include "store/checkpoint.h"
#include "store/error.h"
#include "store/verify.h"
#include "tests/store/failing_file_system.h"
#include "tests/store/memory_file_system.h"

namespace phiz {
namespace {

using test::MemoryFileSystem;

/// A result of one output; current for the subject if there is one.
CommitRequest request_of(const std::string& stage, const std::string& content, const std::string& subject) {
  CommitRequest request;
  request.result.key_text.add("stage", "name", stage);
  request.result.key_text.add("parameter", "p", compute_digest(content).hex());
  request.result.key_text.add("input", "template.obj", compute_digest("the template").hex());
  request.outputs = {{"out", content}};
  request.inputs_to_keep = {"the template"};
  if (!subject.empty()) {
    SubjectRecord record{subject, "/x.ply", compute_digest("scan"), 4, {}, {}};
    record.set_current(stage, request.result.key_text.key());
    request.subject = record;
  }
  return request;
}

class Collect : public ::testing::Test {
 protected:
  Digest commit(const std::string& stage, const std::string& content, const std::string& subject) {
    return store.commit(request_of(stage, content, subject)).result.key();
  }
  CollectReport collect(CollectOptions options) {
    LeaseTable leases(store, real_processes());
    return collect_garbage(store, leases, options);
  }

  MemoryFileSystem disk;
  Store store = Store::open_or_create(disk, "/store");
};

constexpr CollectOptions kEverything{false, 0, {}};

TEST_F(Collect, WhatASubjectNeedsStaysAndTheRestGoes) {
  const Digest kept = commit("fit", "needed", "a");
  const Digest dropped = commit("fit", "not needed", "");
  const CollectReport report = collect(kEverything);
  EXPECT_TRUE(store.find_done_result(kept));
  EXPECT_FALSE(store.find_result(dropped));
  EXPECT_EQ(report.removed.size(), 2u) << "the result and its output";
  EXPECT_EQ(store.read_object(compute_digest("the template")), "the template") << "inputs of what stays";
  EXPECT_TRUE(verify_store(store).ok());
  EXPECT_TRUE(collect(kEverything).removed.empty());
}

TEST_F(Collect, YoungThingsStay) {
  commit("fit", "not needed", "");
  EXPECT_TRUE(collect({}).removed.empty());
  disk.advance_clock(13 * 86400);
  EXPECT_TRUE(collect({}).removed.empty());
  disk.advance_clock(2 * 86400);
  EXPECT_FALSE(collect({}).removed.empty());
}

TEST_F(Collect, ADryRunSaysTheSameAndRemovesNothing) {
  commit("fit", "needed", "a");
  commit("fit", "not needed", "");
  const auto files = disk.list_all_files();
  const CollectReport would = collect({true, 0, {}});
  EXPECT_EQ(disk.list_all_files(), files);
  const CollectReport did = collect(kEverything);
  EXPECT_EQ(would.bytes_removed, did.bytes_removed);
  ASSERT_EQ(would.removed.size(), did.removed.size());
  for (std::size_t i = 0; i < did.removed.size(); ++i) EXPECT_EQ(would.removed[i].what, did.removed[i].what);
}

TEST_F(Collect, ASizeTakesTheOldestFirstAndNoMoreThanItNeeds) {
  for (int i = 0; i < 8; ++i) {
    commit("fit", std::string(1000, static_cast<char>('a' + i)), "");
    disk.advance_clock(10);
  }
  const std::uint64_t before = collect({true, 0, {}}).bytes_before;
  const CollectReport report = collect({false, 0, before - 1500});
  EXPECT_GE(report.bytes_removed, 1500u);
  EXPECT_LE(before - report.bytes_removed, before - 1500);
  EXPECT_TRUE(store.find_object_size(compute_digest(std::string(1000, 'h')))) << "the newest";
  EXPECT_FALSE(store.find_object_size(compute_digest(std::string(1000, 'a')))) << "the oldest";
}

TEST_F(Collect, PinnedResultsStay) {
  const Digest key = commit("fields", "of many subjects", "");
  store.pin(key);
  collect(kEverything);
  EXPECT_TRUE(store.find_done_result(key));
  EXPECT_TRUE(store.unpin(key));
  collect(kEverything);
  EXPECT_FALSE(store.find_result(key));
}

TEST_F(Collect, ARecordThatCannotBeReadStopsIt) {
  commit("fit", "needed", "a");
  commit("fit", "not needed", "");
  disk.flip_bit(store.layout().subject("a"), 100);
  const auto files = disk.list_all_files();
  EXPECT_THROW(collect(kEverything), StoreError);
  EXPECT_EQ(disk.list_all_files(), files);
}

TEST_F(Collect, AResultWhoseFileIsDamagedKeepsItsOutputs) {
  const Digest key = commit("fit", "needed", "a");
  disk.flip_bit(store.layout().result(key), 100);
  collect(kEverything);
  EXPECT_EQ(store.read_object(compute_digest("needed")), "needed");
}

/// Another process commits at every operation of the collector: what it named is there in the end.
TEST_F(Collect, WhatComesToBeNeededMeanwhileIsThereInTheEnd) {
  class Meddler final : public FileSystem {
   public:
    Meddler(FileSystem& files, int at, std::function<void()> act)
        : files_(files), at_(at), act_(std::move(act)) {}
    bool has_acted() const { return calls_ >= at_; }
    std::optional<Status> find_status(const std::filesystem::path& p) override {
      return step().find_status(p);
    }
    void read_blocks(const std::filesystem::path& p, const TakeBlock& t) override {
      step().read_blocks(p, t);
    }
    std::vector<std::string> list_folder(const std::filesystem::path& p) override {
      return step().list_folder(p);
    }
    bool make_folder(const std::filesystem::path& p) override { return step().make_folder(p); }
    void create_file(const std::filesystem::path& p, std::span<const std::byte> b, Mode m) override {
      step().create_file(p, b, m);
    }
    void append(const std::filesystem::path& p, std::span<const std::byte> b) override {
      step().append(p, b);
    }
    void sync_file(const std::filesystem::path& p) override { step().sync_file(p); }
    void sync_folder(const std::filesystem::path& p) override { step().sync_folder(p); }
    void rename(const std::filesystem::path& a, const std::filesystem::path& b) override {
      step().rename(a, b);
    }
    bool create_exclusively(const std::filesystem::path& p, std::span<const std::byte> b) override {
      return step().create_exclusively(p, b);
    }
    bool remove_file(const std::filesystem::path& p) override { return step().remove_file(p); }
    bool remove_folder(const std::filesystem::path& p) override { return step().remove_folder(p); }
    std::optional<double> find_change_time_seconds(const std::filesystem::path& p) override {
      return files_.find_change_time_seconds(p);
    }

   private:
    FileSystem& step() {
      if (++calls_ == at_) act_();
      return files_;
    }
    FileSystem& files_;
    int at_, calls_ = 0;
    std::function<void()> act_;
  };

  for (int n = 1;; ++n) {
    SCOPED_TRACE("at operation " + std::to_string(n));
    MemoryFileSystem one;
    const Store theirs = Store::open_or_create(one, "/store");
    theirs.commit(request_of("fit", "needed", "a"));
    theirs.commit(request_of("fit", "about to be needed", ""));
    Meddler meddler(one, n, [&] { theirs.commit(request_of("fit", "about to be needed", "b")); });
    const Store ours = Store::open(meddler, "/store");
    {
      LeaseTable leases(ours, real_processes());
      collect_garbage(ours, leases, kEverything);
    }
    if (!meddler.has_acted()) break;
    for (const std::string content : {"needed", "about to be needed"}) {
      EXPECT_EQ(theirs.read_object(compute_digest(content)), content);
    }
    for (const std::string name : {"a", "b"}) {
      EXPECT_TRUE(theirs.find_done_result(theirs.find_subject(name)->results.at("fit"))) << name;
    }
    if (HasFailure()) break;
  }
}

/// A collector that dies anywhere has taken nothing that is needed, and the next one finishes.
TEST_F(Collect, KilledAtAnyOperationNothingNeededIsLost) {
  for (std::uint64_t n = 1;; ++n) {
    SCOPED_TRACE("killed at operation " + std::to_string(n));
    MemoryFileSystem one;
    const Store whole = Store::open_or_create(one, "/store");
    whole.commit(request_of("fit", "needed", "a"));
    whole.commit(request_of("fit", "not needed", ""));
    test::FailingFileSystem failing(one, n, test::FailingFileSystem::Failure::kStopped);
    try {
      const Store ours = Store::open(failing, "/store");
      LeaseTable leases(ours, real_processes());
      collect_garbage(ours, leases, kEverything);
    } catch (const StoreError&) {
    }
    EXPECT_EQ(whole.read_object(compute_digest("needed")), "needed");
    one.remove_file(whole.layout().lease(compute_digest("phiz store gc")));  // its process is dead
    LeaseTable leases(whole, real_processes());
    collect_garbage(whole, leases, kEverything);
    EXPECT_EQ(whole.read_object(compute_digest("needed")), "needed");
    EXPECT_FALSE(whole.find_object_size(compute_digest("not needed")));
    EXPECT_FALSE(one.find_status("/store/trash"));
    EXPECT_TRUE(verify_store(whole).ok());
    if (!failing.has_failed() || HasFailure()) break;
  }
}

}  // namespace
}  // namespace phiz
