// Every operation of the store beside commit (fault_test.cpp) and collect (collect_test.cpp), failing at
// every operation of the disk in every way: what the store held before is there, verify finds nothing, and
// the same call again succeeds.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "store/checkpoint.h"
#include "store/error.h"
#include "store/lease.h"
#include "store/pack.h"
#include "store/run_log.h"
#include "store/verify.h"
#include "tests/store/failing_file_system.h"
#include "tests/store/memory_file_system.h"

namespace phiz {
namespace {

using test::FailingFileSystem;
using test::MemoryFileSystem;
using Failure = FailingFileSystem::Failure;

const Digest kUnfinished = compute_digest("a stage under way");

Digest key_of(const std::string& stage) {
  KeyText text;
  text.add("stage", "name", stage);
  return text.key();
}

void commit(const Store& store, const std::string& stage, const std::string& subject) {
  CommitRequest request;
  request.result.key_text.add("stage", "name", stage);
  request.outputs = {{"one", "bytes of " + stage}, {"two", "more bytes of " + stage}};
  SubjectRecord record = store.find_subject(subject).value_or(
      SubjectRecord{subject, "/x.ply", compute_digest("scan"), 4, {}, {}});
  record.set_current(stage, request.result.key_text.key());
  request.subject = record;
  store.commit(std::move(request));
}

/// A disk with a store of two subjects, a checkpoint, a pin, and a pack of a third subject.
std::unique_ptr<MemoryFileSystem> make_disk() {
  auto disk = std::make_unique<MemoryFileSystem>();
  disk->make_folders("/out");
  const Store other = Store::open_or_create(*disk, "/other");
  commit(other, "third", "c");
  pack_to_file(other, {"c"}, "/out/c.tar");
  const Store store = Store::open_or_create(*disk, "/store");
  commit(store, "ingest", "a");
  commit(store, "fit", "a");
  commit(store, "ingest", "b");
  const std::string state = "half of it";
  Checkpoint(store, kUnfinished).save(std::as_bytes(std::span(state)));
  store.pin(key_of("fit"));
  return disk;
}

struct Operation {
  std::string name;
  std::function<void(const Store&)> run;
  std::function<bool(const Store&)> is_done;  ///< after a run that returned
};

std::vector<Operation> list_operations() {
  const auto contains = [](const std::vector<Digest>& keys, const Digest& key) {
    return std::find(keys.begin(), keys.end(), key) != keys.end();
  };
  return {{"pin", [](const Store& store) { store.pin(key_of("ingest")); },
           [=](const Store& store) { return contains(store.list_pins(), key_of("ingest")); }},
          {"unpin", [](const Store& store) { store.unpin(key_of("fit")); },
           [](const Store&) {
             return true;
           }},  // a pin that comes back after a power cut keeps too much, never too little
          {"pack", [](const Store& store) { pack_to_file(store, {"a"}, "/out/a.tar"); },
           [](const Store& store) {
             return store.files().read_file("/out/a.tar") == pack_subjects(store, {"a"});
           }},
          {"unpack", [](const Store& store) { unpack_file(store, "/out/c.tar"); },
           [](const Store& store) {
             return store.find_subject("c") && store.find_done_result(key_of("third")).has_value();
           }},
          {"save a record",
           [](const Store& store) {
             SubjectRecord record = store.find_subject("b").value();
             record.scan_path = "/moved.ply";
             store.save_subject(record);
           },
           [](const Store& store) { return store.find_subject("b")->scan_path == "/moved.ply"; }},
          {"verify", [](const Store& store) { verify_store(store); }, [](const Store&) { return true; }},
          {"restore flipped bits", [](const Store& store) { restore_flipped_bits(store); },
           [](const Store&) { return true; }},
          {"remove a checkpoint", [](const Store& store) { Checkpoint(store, kUnfinished).remove(); },
           [](const Store&) { return true; }},  // likewise
          {"take and give back a lease",
           [](const Store& store) {
             LeaseTable leases(store, real_processes());
             leases.try_acquire(kUnfinished);
           },
           [](const Store&) { return true; }},
          {"write to the log",
           [](const Store& store) {
             static std::int64_t process = 0;  // each has a file of its own
             RunLog(store, {"place", ++process, 1}).append("an event");
           },
           [](const Store&) { return true; }},
          {"repair the marker", [](const Store& store) { Store::repair_marker(store.files(), "/store"); },
           [](const Store&) { return true; }}};
}

void expect_all_is_there(FileSystem& disk) {
  const Store store = Store::open(disk, "/store");
  for (const char* stage : {"ingest", "fit"}) {
    const auto result = store.find_done_result(key_of(stage));
    ASSERT_TRUE(result) << stage;
    for (const auto& [name, output] : result->outputs)
      EXPECT_FALSE(store.read_object(output.digest).empty()) << stage << "/" << name;
  }
  for (const char* subject : {"a", "b"}) EXPECT_TRUE(store.find_subject(subject)) << subject;
  const VerifyReport report = verify_store(store);
  for (const StoreDamage& damage : report.damages) ADD_FAILURE() << damage.what << ": " << damage.cause;
  for (const std::string& name : disk.list_folder("/out"))
    EXPECT_TRUE(name == "c.tar" || name == "a.tar" || name.starts_with(".tmp-")) << name;
}

/// What must hold on a disk after the operation failed or ended, and that it can be done again.
void expect_promises(FileSystem& disk, const Operation& operation, bool has_returned) {
  expect_all_is_there(disk);
  const Store store = Store::open(disk, "/store");
  EXPECT_TRUE(!has_returned || operation.is_done(store)) << "it returned";
  operation.run(store);
  EXPECT_TRUE(operation.is_done(store)) << "again";
  expect_all_is_there(disk);
}

bool try_to_run(FileSystem& files, const Operation& operation) {
  try {
    operation.run(Store::open(files, "/store"));
    return true;
  } catch (const StoreError&) {
    return false;
  }
}

TEST(EveryOperation, KeepsThePromisesWhereverTheDiskFailsOrThePowerIsCut) {
  for (const Operation& operation : list_operations()) {
    SCOPED_TRACE(operation.name);
    for (const Failure failure : {Failure::kOnce, Failure::kFull, Failure::kStopped}) {
      for (std::uint64_t n = 1, is_over = 0; is_over == 0; ++n) {
        SCOPED_TRACE("way " + std::to_string(static_cast<int>(failure)) + ", operation " + std::to_string(n));
        const auto disk = make_disk();
        FailingFileSystem failing(*disk, n, failure);
        const bool has_returned = try_to_run(failing, operation);
        is_over = failing.has_failed() ? 0 : 1;
        if (failure == Failure::kStopped) {
          for (std::uint64_t seed = 1; seed <= 8; ++seed)
            expect_promises(*disk->after_power_cut(seed), operation, has_returned);
        }
        expect_promises(*disk, operation, has_returned);
        if (HasFailure()) return;
      }
    }
  }
}

}  // namespace
}  // namespace phiz
