#include "store/digest.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace phiz {
namespace {

// FIPS 180-4 examples.
TEST(Digest, AgreesWithTheStandard) {
  EXPECT_EQ(compute_digest(std::string_view{}).hex(),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(compute_digest("abc").hex(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(compute_digest(std::string(1000000, 'a')).hex(),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Digest, DoesNotDependOnHowTheBytesAreCut) {
  std::string bytes(1000, '\0');
  for (char& c : bytes) c = static_cast<char>(test::random().below(256));
  for (int round = 0; round < 20; ++round) {
    Sha256 hash;
    for (std::size_t begin = 0; begin < bytes.size();) {
      const std::size_t count = std::min(bytes.size() - begin, test::random().below(200));
      hash.update(std::string_view(bytes).substr(begin, count));
      begin += count;
    }
    EXPECT_EQ(hash.finish(), compute_digest(bytes));
  }
}

TEST(Digest, ItsTextReadsBackAndNothingElseDoes) {
  const Digest digest = compute_digest("x");
  EXPECT_EQ(parse_digest(digest.hex()), digest);
  EXPECT_FALSE(parse_digest(digest.hex() + "0"));
  EXPECT_FALSE(parse_digest(digest.hex().substr(1)));
  for (const char wrong : {'G', 'A', ' ', '/'}) {
    std::string text = digest.hex();
    text[0] = wrong;
    EXPECT_FALSE(parse_digest(text)) << wrong;
  }
  EXPECT_FALSE(parse_digest(""));
}

}  // namespace
}  // namespace phiz
