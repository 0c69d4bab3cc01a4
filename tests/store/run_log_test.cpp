#include "store/run_log.h"

#include <gtest/gtest.h>

#include "store/result_note.h"
#include "store/subject.h"
#include "tests/store/memory_file_system.h"

namespace phiz {
namespace {

TEST(RunLog, EveryWholeLineIsReadWhereverTheTailIsCut) {
  test::MemoryFileSystem disk;
  const Store store = Store::open_or_create(disk, "/store");
  RunLog log(store, {"place", 7, 1});
  const std::vector<std::string> said = {"1 begins", "2 goes\non", "3 ends"};
  for (const std::string& line : said) log.append(line);
  const auto names = disk.list_folder("/store/logs");
  ASSERT_EQ(names.size(), 1u);
  const std::string text = disk.read_file("/store/logs/" + names[0]);
  EXPECT_EQ(read_run_log(store), (std::vector<std::string>{"1 begins", "2 goes on", "3 ends"}));
  for (std::size_t size = 0; size <= text.size(); ++size) {
    disk.remove_file("/store/logs/" + names[0]);
    disk.append("/store/logs/" + names[0], std::as_bytes(std::span(text.data(), size)));
    const auto lines = read_run_log(store);
    EXPECT_EQ(lines.size(), static_cast<std::size_t>(std::count(text.begin(), text.begin() + size, '\n')));
  }
}

TEST(ResultNotes, ReadBackAndKeepOutWhatCouldBreakALine) {
  Result result;
  result.key_text.add("stage", "name", "fit");
  result.key_text.add("input", "scan", compute_digest("scan").hex());
  result.key_text.add("input", "scan.extension", ".ply");
  result.outputs["head.glb"] = {compute_digest("head"), 4};
  result.run.seconds = 1.25;
  result.seal = compute_digest("seal");
  const ResultNote note = make_note(result);
  EXPECT_EQ(note.inputs.size(), 1u) << "only digests";
  EXPECT_EQ(parse_notes(format_notes({{"fit", note}})), (std::map<std::string, ResultNote>{{"fit", note}}));
  ResultNote hostile = note;
  hostile.outputs["a b"] = {};
  EXPECT_EQ(format_notes({{"fit", hostile}}), "");
  EXPECT_TRUE(parse_notes("result fit nonsense\n").empty());
  EXPECT_TRUE(parse_notes("output x " + compute_digest("x").hex() + " 1\n").empty());
}

TEST(ResultNotes, ARecordKeepsThemAndALaterResultDropsThem) {
  SubjectRecord record{"a", "/a.ply", compute_digest("scan"), 4, {}, {}};
  ResultNote note{compute_digest("1"), compute_digest("seal"), 2, {{"scan", compute_digest("scan")}}, {}};
  note.outputs["head.glb"] = {compute_digest("head"), 12};
  record.set_current("fit", note);
  const SubjectRecord back = parse_subject(format_subject(record), "it");
  EXPECT_EQ(back, record);
  ASSERT_NE(back.find_note("fit"), nullptr);
  record.set_current("fit", compute_digest("2"));
  EXPECT_EQ(record.find_note("fit"), nullptr);
}

TEST(RunLog, AnyFlippedBitOfAWholeLineIsFoundAndACutTailIsNone) {
  test::MemoryFileSystem disk;
  const Store store = Store::open_or_create(disk, "/store");
  RunLog log(store, {"place", 7, 1});
  for (const std::string line : {"1 begins", "2 goes on", "3 ends"}) log.append(line);
  const auto file = store.layout().logs() / disk.list_folder("/store/logs").at(0);
  const std::string text = disk.read_file(file);
  for (std::size_t size = 0; size <= text.size(); ++size)
    EXPECT_EQ(find_damaged_line(std::string_view(text).substr(0, size)), 0u) << size;
  for (std::size_t bit = 0; bit < 8 * text.size(); ++bit) {
    std::string spoilt = text;
    spoilt[bit / 8] = static_cast<char>(spoilt[bit / 8] ^ (1 << (bit % 8)));
    EXPECT_NE(find_damaged_line(spoilt), 0u) << bit;
  }
}

TEST(RunLog, AFileNamedAfterItsBytesIsToldFromAnother) {
  const std::string name = make_checked_name("slurm-1", "a list", ".csv");
  EXPECT_TRUE(is_as_its_name_says(name, "a list"));
  EXPECT_FALSE(is_as_its_name_says(name, "a lisu"));
  EXPECT_TRUE(is_as_its_name_says("slurm-1-fit1-12_3.txt", "whatever a task has printed"));
}

}  // namespace
}  // namespace phiz
