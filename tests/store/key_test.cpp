#include "store/key.h"

#include <gtest/gtest.h>

#include "store/error.h"

namespace phiz {
namespace {

KeyText example() {
  KeyText text;
  text.add("stage", "name", "ingest");
  text.add("parameter", "ingest.voxel_mm", "0.5");
  text.add("input", "scan", "line one\ninput scan 3 abc\n");
  return text;
}

TEST(KeyText, IsReadableAndLengthDelimited) {
  EXPECT_EQ(example().text(),
            "phiz-key 1\n"
            "stage name 6 ingest\n"
            "parameter ingest.voxel_mm 3 0.5\n"
            "input scan 26 line one\ninput scan 3 abc\n\n");
}

TEST(KeyText, ReadsBackWhateverTheValuesHold) {
  const auto parsed = parse_key_text(example().text());
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->entries(), example().entries());
  EXPECT_EQ(parsed->key(), example().key());
}

TEST(KeyText, EveryTruncationIsRefusedOrAnotherKey) {
  const std::string text = example().text();
  for (std::size_t length = 0; length < text.size(); ++length) {
    const auto parsed = parse_key_text(text.substr(0, length));
    EXPECT_TRUE(!parsed || parsed->key() != example().key()) << length;
  }
}

TEST(KeyText, NoValueCanImitateAnotherEntry) {
  KeyText one, two;
  one.add("parameter", "a", "1\nparameter b 1 2");
  two.add("parameter", "a", "1");
  two.add("parameter", "b", "2");
  EXPECT_NE(one.key(), two.key());
}

TEST(KeyText, RefusesNamesThatAreNoWords) {
  KeyText text;
  EXPECT_THROW(text.add("parameter", "a b", "1"), StoreError);
  EXPECT_THROW(text.add("parameter", "", "1"), StoreError);
  EXPECT_THROW(text.add("Parameter", "a", "1"), StoreError);
  EXPECT_THROW(text.add("parameter", "a\n", "1"), StoreError);
}

TEST(KeyText, DifferencesNameEachEntryThatChangedCameOrWent) {
  KeyText before, after;
  before.add("parameter", "same", "1");
  before.add("parameter", "changed", "1");
  before.add("parameter", "gone", "1");
  after.add("parameter", "same", "1");
  after.add("parameter", "changed", "2");
  after.add("input", "new", "3");
  const auto differences = compare_keys(before, after);
  ASSERT_EQ(differences.size(), 3u);
  EXPECT_EQ(differences[0].name, "changed");
  EXPECT_EQ(differences[0].before, "1");
  EXPECT_EQ(differences[0].after, "2");
  EXPECT_EQ(differences[1].name, "new");
  EXPECT_FALSE(differences[1].before);
  EXPECT_EQ(differences[2].name, "gone");
  EXPECT_FALSE(differences[2].after);
  EXPECT_TRUE(compare_keys(before, before).empty());
}

}  // namespace
}  // namespace phiz
