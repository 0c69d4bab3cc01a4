#include "store/sealed_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "store/error.h"

namespace phiz {
namespace {

const nlohmann::json kObject = {{"a", 1},
                                {"b", {{"c", "text"}, {"d", nlohmann::json::array({1.5, nullptr})}}}};

TEST(SealedJson, ReadsBackWhatWasSealed) {
  EXPECT_EQ(unseal_json(seal_json(kObject), "it"), kObject);
  EXPECT_TRUE(nlohmann::json::parse(seal_json(kObject)).is_object());
}

TEST(SealedJson, AnyFlippedBitIsFound) {
  const std::string text = seal_json(kObject);
  for (std::size_t bit = 0; bit < 8 * text.size(); ++bit) {
    std::string flipped = text;
    flipped[bit / 8] ^= static_cast<char>(1 << (bit % 8));
    EXPECT_THROW(unseal_json(flipped, "it"), StoreError) << bit;
  }
}

TEST(SealedJson, AnyTruncationOrAdditionIsFound) {
  const std::string text = seal_json(kObject);
  for (std::size_t length = 0; length < text.size(); ++length) {
    EXPECT_THROW(unseal_json(text.substr(0, length), "it"), StoreError) << length;
  }
  EXPECT_THROW(unseal_json(text + "\n", "it"), StoreError);
}

}  // namespace
}  // namespace phiz
