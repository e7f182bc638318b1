#include "client/cli/json.h"

#include <limits>

#include "gtest/gtest.h"

namespace dynmesh::cli {
namespace {

TEST(Json, ObjectsKeepTheOrderOfTheirKeys) {
  EXPECT_EQ(JsonObject()
                .Add("z", 1)
                .Add("a", ~std::uint64_t{0})
                .Add("f", 0.1)
                .Add("t", true)
                .AddText("s", "x")
                .AddTexts("l", {"p", "q"})
                .AddCounts("c", {0, ~std::uint64_t{0}})
                .AddNumbers("n", {0.5, std::numeric_limits<double>::quiet_NaN()})
                .AddObject("o", JsonObject().Add("k", -1))
                .AddObjects("e", {})
                .ToLine(),
            "{\"z\": 1, \"a\": 18446744073709551615, \"f\": 0.1, \"t\": true, \"s\": \"x\", "
            "\"l\": [\"p\", \"q\"], \"c\": [0, 18446744073709551615], \"n\": [0.5, null], \"o\": "
            "{\"k\": -1}, \"e\": []}\n");
}

TEST(Json, HasNoNumberThatIsNotFinite) {
  EXPECT_EQ(JsonObject().Add("x", std::numeric_limits<double>::infinity()).ToString(),
            "{\"x\": null}");
  EXPECT_EQ(JsonObject().Add("x", std::numeric_limits<double>::quiet_NaN()).ToString(),
            "{\"x\": null}");
}

TEST(Json, TextIsEscapedAndAlwaysUtf8) {
  EXPECT_EQ(JsonQuote("a\"b\\c\n\x01"), "\"a\\\"b\\\\c\\n\\u0001\"");
  EXPECT_EQ(JsonQuote("\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80"),
            "\"\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80\"");
  EXPECT_EQ(JsonQuote("\xff\xc3"), "\"\xef\xbf\xbd\xef\xbf\xbd\"");
  EXPECT_EQ(JsonQuote("\xc0\x80"), "\"\xef\xbf\xbd\xef\xbf\xbd\"");      // overlong
  EXPECT_EQ(JsonQuote("\xed\xa0\x80").find("\xed"), std::string::npos);  // surrogate
}

}  // namespace
}  // namespace dynmesh::cli
