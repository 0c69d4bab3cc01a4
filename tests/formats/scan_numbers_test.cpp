#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <string>

#include "formats/readers/text_lines.h"
#include "tests/support/random.h"

namespace phiz::readers {
namespace {

double parsed(const std::string& text) {
  double value = 0.0;
  const char* stop = parse_number(text.data(), text.data() + text.size(), value);
  EXPECT_EQ(stop, text.data() + text.size()) << text;
  return value;
}

std::string decimal(std::uint64_t digits, std::size_t decimals) {
  std::string text = std::to_string(digits);
  if (text.size() <= decimals) text.insert(0, decimals + 1 - text.size(), '0');
  if (decimals > 0) text.insert(text.end() - static_cast<std::ptrdiff_t>(decimals), '.');
  return text;
}

TEST(ScanNumbers, AgreeWithTheStandardLibraryToTheLastBit) {
  for (int i = 0; i < 100000; ++i) {
    const std::uint64_t digits = test::random().next() >> test::random().below(64);
    std::string text = decimal(digits, test::random().below(22));
    if (i % 2) text.insert(text.begin(), '-');
    if (i % 5 == 0) (text += 'e') += std::to_string(static_cast<int>(test::random().below(60)) - 30);
    double expected = 0.0;
    std::from_chars(text.data(), text.data() + text.size(), expected);
    EXPECT_EQ(parsed(text), expected) << text;
  }
}

TEST(ScanNumbers, AcceptWhatProgramsWrite) {
  EXPECT_EQ(parsed("+1.5"), 1.5);
  EXPECT_EQ(parsed(".5"), 0.5);
  EXPECT_EQ(parsed("5."), 5.0);
  EXPECT_EQ(parsed("1E+3"), 1000.0);
  EXPECT_TRUE(std::signbit(parsed("-0")));
  EXPECT_TRUE(std::isnan(parsed("NaN")));
  EXPECT_TRUE(std::isnan(parsed("-1.#IND")));
  EXPECT_TRUE(std::isnan(parsed("1.#QNAN0")));
  EXPECT_EQ(parsed("-1.#INF"), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(parsed("1e999"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parsed("-1e-999"), 0.0);
  std::string tiny = "0.";
  tiny.append(400, '0') += '1';
  EXPECT_EQ(parsed(tiny), 0.0);
  EXPECT_EQ(parsed(std::string(400, '9')), std::numeric_limits<double>::infinity());
}

TEST(ScanNumbers, RefuseWhatIsNone) {
  double value = 0.0;
  for (const std::string text : {"", "-", "+", ".", "-.", "abc", "e5", "--1", "+-1", "#"}) {
    const char* stop = parse_number(text.data(), text.data() + text.size(), value);
    EXPECT_EQ(stop, nullptr) << text;
  }
}

}  // namespace
}  // namespace phiz::readers
