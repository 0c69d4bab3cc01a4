#include "store/subject.h"

#include <gtest/gtest.h>

#include "store/error.h"

namespace phiz {
namespace {

TEST(Subject, NamesThatCouldLeaveTheFolderAreRefused) {
  using namespace std::string_literals;
  for (const std::string& name : {""s, "."s, ".."s, "../x"s, "a/b"s, "/etc/passwd"s, ".hidden"s, "-n"s,
                                  "a\0b"s, "a b"s, "a\nb"s, "a\\b"s, "caf\xc3\xa9"s,
                                  "a\xe2\x88\x95"
                                  "b"s,
                                  std::string(101, 'a'), std::string(300, 'x')}) {
    EXPECT_THROW(validate_subject_name(name), StoreError) << name;
  }
  for (const std::string& name : {"a"s, "dev00"s, "Lee-Perry_Smith.2"s, "_x"s, std::string(100, 'a')}) {
    EXPECT_NO_THROW(validate_subject_name(name)) << name;
  }
}

TEST(Subject, AnyStemBecomesAValidNameAndDifferentStemsStayApart) {
  using namespace std::string_literals;
  const std::vector<std::string> stems = {"dev00"s,
                                          ".."s,
                                          ""s,
                                          "-x"s,
                                          "a\0b"s,
                                          "a b"s,
                                          "a?b"s,
                                          std::string(300, 'a'),
                                          "../../etc"s,
                                          "Jos\xc3\xa9"s,
                                          "Jos\xc3\xa8"s,
                                          std::string(301, 'a')};
  std::map<std::string, std::string> stem_of_name;
  for (const std::string& stem : stems) {
    const std::string name = make_subject_name(stem);
    EXPECT_NO_THROW(validate_subject_name(name)) << name;
    EXPECT_TRUE(stem_of_name.emplace(name, stem).second) << name;
  }
  EXPECT_EQ(make_subject_name("dev00"), "dev00");
}

TEST(Subject, RecordReadsBack) {
  SubjectRecord record{"dev00", "/scans/dev00.ply", compute_digest("scan"), 12, {}, {}};
  record.set_current("ingest", compute_digest("1"));
  record.set_current("ingest", compute_digest("2"));
  record.set_current("align", compute_digest("3"));
  EXPECT_EQ(parse_subject(format_subject(record), "it"), record);
}

TEST(Subject, HistoryKeepsWhatWasCurrentOldestFirstAndIsBounded) {
  SubjectRecord record;
  for (int i = 0; i < 100; ++i) {
    record.set_current("fit", compute_digest(std::to_string(i)));
    record.set_current("fit", compute_digest(std::to_string(i)));  // the same again changes nothing
  }
  EXPECT_EQ(record.results["fit"], compute_digest("99"));
  ASSERT_EQ(record.history.size(), 64u);
  EXPECT_EQ(record.history.back().key, compute_digest("98"));
  EXPECT_EQ(record.history.front().key, compute_digest("35"));
}

}  // namespace
}  // namespace phiz
