// The promises of store/README.md, held at every operation of the disk: one failure, a full disk, a dead
// process, and a power cut that drops unsynced bytes and reorders names.

#include <gtest/gtest.h>

#include <functional>

#include "store/checkpoint.h"
#include "store/error.h"
#include "store/verify.h"
#include "tests/store/failing_file_system.h"
#include "tests/store/memory_file_system.h"

namespace phiz {
namespace {

using test::FailingFileSystem;
using test::MemoryFileSystem;
using Failure = FailingFileSystem::Failure;

CommitRequest request_of(const std::string& stage, const std::string& content) {
  CommitRequest request;
  request.result.key_text.add("stage", "name", stage);
  request.outputs = {{"one", content}, {"two", content + content}};
  SubjectRecord record{"dev00", "/x.ply", compute_digest("scan"), 4, {}, {}};
  record.set_current(stage, request.result.key_text.key());
  request.subject = record;
  return request;
}

const Digest kCheckpointKey = compute_digest("checkpoint");

/// What a caller was told has happened.
struct Told {
  std::vector<Digest> committed;
  std::string checkpoint;  // the last state whose save returned
};

/// A small life of a store. Returns early, by exception, where the disk fails.
void live(FileSystem& files, Told& told) {
  const Store store = Store::open_or_create(files, "/store");
  told.committed.push_back(store.commit(request_of("ingest", "some bytes of a cloud")).result.key());
  const Checkpoint checkpoint(store, kCheckpointKey);
  for (const std::string state : {"state 1", "a longer state 2"}) {
    checkpoint.save(std::as_bytes(std::span(state)));
    told.checkpoint = state;
  }
  told.committed.push_back(store.commit(request_of("fit", "a mesh")).result.key());
}

bool try_to_live(FileSystem& files, Told& told) {
  try {
    live(files, told);
    return true;
  } catch (const StoreError&) {
    return false;
  }
}

void expect_promises(FileSystem& disk, const Told& told) {
  if (!told.committed.empty()) {
    const Store store = Store::open(disk, "/store");
    for (const Digest& key : told.committed) EXPECT_TRUE(store.find_done_result(key)) << key.hex();
    const VerifyReport report = verify_store(store);
    for (const StoreDamage& damage : report.damages) ADD_FAILURE() << damage.what << ": " << damage.cause;
    if (!told.checkpoint.empty()) {
      const auto state = Checkpoint(store, kCheckpointKey).load();
      ASSERT_TRUE(state);
      EXPECT_GE(state->size(), told.checkpoint.size()) << "a later state may be there, an older one not";
    }
  }
  Told again;
  live(disk, again);  // the same command again finishes
  EXPECT_EQ(again.committed.size(), 2u);
  EXPECT_TRUE(verify_store(Store::open(disk, "/store")).ok());
}

/// Calls `check` for a life that fails at n, for every n until a life ends before its n-th operation.
void for_every_failure(Failure failure,
                       const std::function<void(MemoryFileSystem& disk, const Told& told)>& check) {
  for (std::uint64_t n = 1;; ++n) {
    SCOPED_TRACE("failing at operation " + std::to_string(n));
    MemoryFileSystem disk;
    FailingFileSystem failing(disk, n, failure);
    Told told;
    const bool finished = try_to_live(failing, told);
    check(disk, told);
    if (!failing.has_failed()) {
      EXPECT_TRUE(finished);
      EXPECT_GT(n, 40u) << "the life should have many operations";
      return;
    }
    if (::testing::Test::HasFailure()) return;
  }
}

TEST(StoreFaults, OneFailedOperationLosesNothing) {
  for_every_failure(Failure::kOnce,
                    [](MemoryFileSystem& disk, const Told& told) { expect_promises(disk, told); });
}

TEST(StoreFaults, AFullDiskLosesNothingAndWorkGoesOnOnceThereIsSpace) {
  for_every_failure(Failure::kFull,
                    [](MemoryFileSystem& disk, const Told& told) { expect_promises(disk, told); });
}

TEST(StoreFaults, AKillAtAnyOperationLosesNothing) {
  for_every_failure(Failure::kStopped,
                    [](MemoryFileSystem& disk, const Told& told) { expect_promises(disk, told); });
}

TEST(StoreFaults, APowerCutAtAnyOperationLosesNothing) {
  for_every_failure(Failure::kStopped, [](MemoryFileSystem& disk, const Told& told) {
    for (std::uint64_t seed = 1; seed <= 16; ++seed) {
      SCOPED_TRACE("power cut " + std::to_string(seed));
      const auto after = disk.after_power_cut(seed);
      expect_promises(*after, told);
    }
  });
}

/// The gate is alive: a writer that does not sync must be caught by the same power cuts.
TEST(StoreFaults, TheModelCatchesAWriterThatDoesNotSync) {
  bool lost = false;
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    MemoryFileSystem disk;
    const std::string bytes = "some bytes";
    disk.create_file("/temporary", std::as_bytes(std::span(bytes)), FileSystem::Mode::kWritable);
    disk.rename("/temporary", "/target");
    disk.sync_folder("/");
    if (disk.after_power_cut(seed)->read_file("/target") != bytes) lost = true;
  }
  EXPECT_TRUE(lost);
}

}  // namespace
}  // namespace phiz
