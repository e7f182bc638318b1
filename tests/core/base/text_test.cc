#include "core/base/text.h"

#include "gtest/gtest.h"

namespace dynmesh::text {
namespace {

TEST(Text, ConcatTakesTextsCharactersAndNumbers) {
  EXPECT_EQ(Concat("a", std::string("b"), std::string_view("c"), 'd', 5, ~0ULL, 0.1, -2),
            "abcd5184467440737095516150.1-2");
}

TEST(Text, HexHasAllDigits) { EXPECT_EQ(Hex(0xabcULL), "0000000000000abc"); }

TEST(Text, QuotedIsHarmlessAndShort) {
  EXPECT_EQ(Quoted("abc"), "'abc'");
  EXPECT_EQ(Quoted(std::string_view("a\0\n\x1b", 4)), "'a\\x00\\x0a\\x1b'");
  EXPECT_EQ(Quoted(std::string(1000, 'x')), "'" + std::string(40, 'x') + "...'");
}

TEST(Text, SplitKeepsEmptyParts) {
  EXPECT_EQ(Split("a,,b,", ','), (std::vector<std::string_view>{"a", "", "b", ""}));
  EXPECT_EQ(Split("", ','), (std::vector<std::string_view>{""}));
}

}  // namespace
}  // namespace dynmesh::text
