// No name and no link leads out of the store: on the real disk.

#include <gtest/gtest.h>

#include <fstream>

#include "store/error.h"
#include "store/store.h"
#include "store/verify.h"
#include "tests/support/temp_folder.h"

namespace phiz {
namespace {

namespace fs = std::filesystem;

std::string read_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class HostileNames : public ::testing::Test {
 protected:
  HostileNames() {
    std::ofstream(folder / "secret.txt") << "not yours";
    fs::create_directory(folder / "outside");
  }
  CommitRequest request(const std::string& subject) const {
    CommitRequest request;
    request.result.key_text.add("stage", "name", "fit");
    request.outputs = {{"head.glb", "bytes"}};
    request.subject = SubjectRecord{subject, "/x.ply", compute_digest("scan"), 4, {}, {}};
    return request;
  }
  std::set<std::string> names_outside() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder.path())) names.insert(entry.path().filename());
    for (const auto& entry : fs::directory_iterator(folder / "outside"))
      names.insert(entry.path().filename());
    return names;
  }
  const test::TempFolder folder;
  Store store = Store::open_or_create(real_file_system(), folder / "store");
};

TEST_F(HostileNames, SubjectsCannotLeaveTheirFolder) {
  using namespace std::string_literals;
  const auto before = names_outside();
  for (const std::string& name : {"../a"s, "/tmp/a"s, ".."s, "a/b"s, "a\0b"s, std::string(300, 'x'),
                                  "a\xe2\x88\x95"s
                                  "b",
                                  "\xd0\xb0"s, ".a"s, "a\n"s}) {
    EXPECT_THROW(store.commit(request(name)), StoreError) << name;
    EXPECT_THROW(store.find_subject(name), StoreError) << name;
  }
  EXPECT_EQ(names_outside(), before);
  EXPECT_TRUE(store.list_subjects().empty());
}

TEST_F(HostileNames, AnOutputMayHaveAnyNameForItNamesNoFile) {
  CommitRequest hostile = request("a");
  hostile.outputs = {{"../../x", "one"}, {std::string(300, 'y'), "two"}, {"/etc/passwd", "three"}};
  const auto before = names_outside();
  const Digest key = store.commit(std::move(hostile)).result.key();
  EXPECT_EQ(store.find_done_result(key)->outputs.size(), 3u);
  EXPECT_EQ(names_outside(), before);
}

TEST_F(HostileNames, ALinkInPlaceOfAFileIsNeitherBelievedNorWrittenThrough) {
  const Digest bytes = compute_digest("bytes");
  store.commit(request("a"));
  const std::vector<fs::path> files = {store.layout().object(bytes), store.layout().subject("a"),
                                       store.layout().result(request("a").result.key_text.key())};
  for (const fs::path& file : files) {
    fs::remove(file);
    fs::create_symlink(folder / "secret.txt", file);
  }
  EXPECT_THROW(store.read_object(bytes), StoreError);
  EXPECT_THROW(store.find_subject("a"), StoreError);
  EXPECT_FALSE(verify_store(store).ok());
  EXPECT_NO_THROW(store.commit(request("a")));
  EXPECT_EQ(store.read_object(bytes), "bytes");
  EXPECT_EQ(store.find_subject("a")->name, "a");
  EXPECT_EQ(read_text(folder / "secret.txt"), "not yours");
  for (const fs::path& file : files) EXPECT_FALSE(fs::is_symlink(file)) << file;
}

TEST_F(HostileNames, FilesThatAreNotOursAreLeftAlone) {
  for (const char* name : {"objects/ab", "objects/zz", "objects/README", "results/notes.txt",
                           "subjects/.hidden.json", "leases/x", "checkpoints/y"}) {
    fs::create_directories((folder / "store" / name).parent_path());
    std::ofstream(folder / "store" / name) << "x";
  }
  fs::remove(folder / "store/objects/ab");
  fs::remove(folder / "store/objects/zz");
  EXPECT_TRUE(store.list_objects().empty());
  EXPECT_TRUE(store.list_results().empty());
  EXPECT_TRUE(verify_store(store).objects == 0);
  EXPECT_TRUE(fs::exists(folder / "store/results/notes.txt"));
}

}  // namespace
}  // namespace phiz
