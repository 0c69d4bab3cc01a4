#include "store/pack.h"

#include <gtest/gtest.h>

#include "store/error.h"
#include "store/verify.h"
#include "tests/store/memory_file_system.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using test::MemoryFileSystem;

void add_subject(const Store& store, const std::string& name, const std::string& content) {
  CommitRequest request;
  request.result.key_text.add("stage", "name", "fit");
  request.result.key_text.add("input", "scan", compute_digest(content).hex());
  request.outputs = {{"one", content}, {"two", content + " twice"}};
  SubjectRecord record{name, "/" + name + ".ply", compute_digest(content), content.size(), {}, {}};
  record.set_current("fit", request.result.key_text.key());
  request.subject = record;
  store.commit(std::move(request));
}

class Pack : public ::testing::Test {
 protected:
  Pack() {
    add_subject(store, "a", "first");
    add_subject(store, "b", "second");
    add_subject(store, std::string(100, 'n'), "third");
  }
  MemoryFileSystem disk, other_disk;
  Store store = Store::open_or_create(disk, "/store");
  Store other = Store::open_or_create(other_disk, "/other");
};

TEST_F(Pack, TakesOverWholeSubjectsAndOnlyThem) {
  const std::string archive = pack_subjects(store, {"a", std::string(100, 'n')});
  const UnpackReport report = unpack_subjects(other, archive);
  EXPECT_EQ(report.subjects, (std::vector<std::string>{"a", std::string(100, 'n')}));
  EXPECT_EQ(other.list_subjects(), report.subjects);
  EXPECT_TRUE(other.find_done_result(other.find_subject("a")->results.at("fit")));
  EXPECT_EQ(other.read_object(compute_digest("third")), "third");
  EXPECT_FALSE(other.find_object_size(compute_digest("second")));
  EXPECT_TRUE(verify_store(other).ok());
  EXPECT_EQ(pack_subjects(other, report.subjects), archive) << "same subjects, same bytes";
  EXPECT_NO_THROW(unpack_subjects(other, archive)) << "again: everything is there";
}

/// The bytes come in blocks of any length; what is in memory is one object.
TEST_F(Pack, IsReadInAnyBlocksAndWrittenInOrder) {
  std::string archive;
  std::size_t largest = 0;
  add_subject(store, "large", std::string(50'000, 'x'));
  add_subject(store, "larger", std::string(60'000, 'y'));
  pack_subjects(store, {"a", "large", "larger"}, [&](std::string_view part) {
    archive += part;
    largest = std::max(largest, part.size());
  });
  EXPECT_EQ(archive, pack_subjects(store, {"a", "large", "larger"}));
  EXPECT_LT(largest, archive.size() / 3);
  for (const std::size_t block : {1, 7, 512, 513, 100'000}) {
    MemoryFileSystem third_disk;
    const Store third = Store::open_or_create(third_disk, "/third");
    const ReadPack read = [&](const auto& take) {
      for (std::size_t at = 0; at < archive.size(); at += block)
        take(std::string_view(archive).substr(at, block));
    };
    EXPECT_EQ(unpack_subjects(third, read).subjects.size(), 3u);
    EXPECT_EQ(pack_subjects(third, {"a", "large", "larger"}), archive);
  }
}

TEST_F(Pack, AFileIsThereWholeOrNotAtAll) {
  disk.make_folders("/out");
  const std::uint64_t size = pack_to_file(store, {"a"}, "/out/a.tar");
  EXPECT_EQ(size, disk.read_file("/out/a.tar").size());
  EXPECT_EQ(unpack_file(store, "/out/a.tar").subjects, std::vector<std::string>{"a"});
  int calls = 0;
  const auto stop = [&] {
    if (++calls == 5) throw std::runtime_error("stopped");
  };
  EXPECT_THROW(pack_to_file(store, {"a", "b"}, "/out/b.tar", stop), std::runtime_error);
  EXPECT_EQ(disk.list_folder("/out"), std::vector<std::string>{"a.tar"});
}

TEST_F(Pack, AnotherSubjectOfTheNameIsKeptUnlessToldOtherwise) {
  add_subject(other, "a", "quite another");
  const std::string archive = pack_subjects(store, {"a"});
  EXPECT_THROW(unpack_subjects(other, archive), StoreError);
  EXPECT_FALSE(other.find_object_size(compute_digest("first"))) << "nothing is written before all is checked";
  unpack_subjects(other, archive, {true});
  EXPECT_EQ(other.find_subject("a")->scan_digest, compute_digest("first"));
}

TEST_F(Pack, DamagedThingsAreNotPacked) {
  disk.flip_bit(store.layout().object(compute_digest("first")), 3);
  EXPECT_THROW(pack_subjects(store, {"a"}), StoreError);
  EXPECT_THROW(pack_subjects(store, {"none"}), StoreError);
}

TEST_F(Pack, EveryTruncationIsRefusedAndWritesNothing) {
  const std::string archive = pack_subjects(store, {"a"});
  const auto files = other_disk.list_all_files();
  for (std::size_t size = 0; size + 512 < archive.size();
       size += size % 512 < 3 || size % 512 > 509 ? 1 : 29) {
    EXPECT_THROW(unpack_subjects(other, archive.substr(0, size)), StoreError) << size;
  }
  EXPECT_EQ(other_disk.list_all_files(), files);
}

TEST_F(Pack, AFlippedBitIsRefusedOrInPaddingThatCarriesNothing) {
  const std::string archive = pack_subjects(store, {"a"});
  for (int i = 0; i < 3000; ++i) {
    std::string changed = archive;
    changed[test::random().below(changed.size())] ^= static_cast<char>(1 << test::random().below(8));
    MemoryFileSystem third_disk;
    const Store third = Store::open_or_create(third_disk, "/third");
    try {
      unpack_subjects(third, changed);
      EXPECT_EQ(third.read_object(compute_digest("first")), "first");
    } catch (const StoreError&) {
      EXPECT_TRUE(third.list_objects().empty());
    }
  }
}

TEST_F(Pack, NamesThatBelongInNoStoreAreRefused) {
  const std::string archive = pack_subjects(store, {"a"});
  for (const std::string name :
       {"../../etc/passwd", "/etc/passwd", "objects/../../x", "subjects/../a.json", "results/x.json",
        "phiz-store.json", "objects/ab/cd", "leases/x", "subjects/a.json"}) {
    std::string changed = archive;
    const std::size_t at = changed.find("objects/");
    changed.replace(at, 100, name + std::string(100 - name.size(), '\0'));
    unsigned sum = 0;
    for (std::size_t i = 0; i < 512; ++i)
      sum += i >= 148 && i < 156 ? ' ' : static_cast<unsigned char>(changed[at + i]);
    char digits[8];
    std::snprintf(digits, sizeof digits, "%06o", sum);
    changed.replace(at + 148, 6, digits);
    EXPECT_THROW(unpack_subjects(other, changed), StoreError) << name;
  }
  EXPECT_TRUE(other.list_objects().empty());
}

}  // namespace
}  // namespace phiz
