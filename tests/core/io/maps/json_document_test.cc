#include "core/io/maps/json_document.h"

#include <string>

#include "gtest/gtest.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using Kind = JsonDocument::Kind;

std::string ErrorOf(std::string_view text, const JsonLimits& limits = {}) {
  const auto json = JsonDocument::Parse("m.json", text, limits);
  EXPECT_FALSE(json.ok()) << text;
  EXPECT_EQ(json.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(json.status().message());
}

TEST(JsonDocument, ValuesKnowTheirLines) {
  const auto json = JsonDocument::Parse("m.json",
                                        "{\"a\": [1,\n -2.5e1\n, \"x\\n\"\n],\n\n"
                                        "\"b\": {\"c\": null,\n\"d\": true}}\n");
  ASSERT_TRUE(json.ok()) << json.status();
  EXPECT_EQ(json->kind(0), Kind::kObject);
  EXPECT_EQ(json->line(0), 1);
  const auto a = json->Find(0, "a");
  ASSERT_TRUE(a.has_value());
  EXPECT_EQ(json->kind(*a), Kind::kArray);
  std::vector<int> lines;
  std::vector<Kind> kinds;
  ASSERT_TRUE(json->ForEach(*a,
                            [&](JsonDocument::Index i) {
                              lines.push_back(json->line(i));
                              kinds.push_back(json->kind(i));
                              return absl::OkStatus();
                            })
                  .ok());
  EXPECT_EQ(lines, (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(kinds, (std::vector<Kind>{Kind::kNumber, Kind::kNumber, Kind::kString}));
  EXPECT_EQ(json->number(json->Next(*a, json->First(*a))), -25);
  const auto b = json->Find(0, "b");
  ASSERT_TRUE(b.has_value());
  EXPECT_EQ(json->line(*b), 6);
  EXPECT_EQ(json->kind(*json->Find(*b, "c")), Kind::kNull);
  EXPECT_EQ(json->line(*json->Find(*b, "d")), 7);
  EXPECT_FALSE(json->Find(0, "c").has_value());
}

TEST(JsonDocument, EmptyContainersHaveNothingInThem) {
  const auto json = JsonDocument::Parse("m.json", "[[], {}, 7]");
  ASSERT_TRUE(json.ok());
  const auto first = json->First(0), second = json->Next(0, first);
  EXPECT_GE(json->First(first), json->End(first));
  EXPECT_GE(json->First(second), json->End(second));
  EXPECT_EQ(json->number(json->Next(0, second)), 7);
}

TEST(JsonDocument, WhatIsNoJsonIsRefusedWithItsLine) {
  EXPECT_EQ(ErrorOf(""), "m.json:1: the file holds no JSON");
  EXPECT_TRUE(ErrorOf("{\n\"a\": [1,\n2").starts_with("m.json:3: the JSON text ends"));
  EXPECT_TRUE(ErrorOf("[1,\n2,\nNaN]").starts_with("m.json:3: this is no JSON"));
  EXPECT_TRUE(ErrorOf("[1] 2").starts_with("m.json:1: "));
  EXPECT_TRUE(ErrorOf("[1,\n\n]").starts_with("m.json:3: "));
  EXPECT_TRUE(ErrorOf("\"\xff\xfe\"").starts_with("m.json:1: "));
}

TEST(JsonDocument, NumbersPastADoubleAreRefused) {
  EXPECT_TRUE(ErrorOf("[1,\n1e999]").starts_with("m.json:2: the number '1e999'"));
  EXPECT_TRUE(JsonDocument::Parse("m.json", "[18446744073709551616, 1e-999]").ok());
}

TEST(JsonDocument, DepthAndSizeAreLimited) {
  const JsonLimits limits{.depth = 3, .bytes = 20};
  EXPECT_TRUE(JsonDocument::Parse("m.json", "[[[1]]]", limits).ok());
  EXPECT_NE(ErrorOf("[[\n[[1]]]]", limits).find("m.json:2: arrays and objects"), std::string::npos);
  EXPECT_NE(ErrorOf("[1, 2, 3, 4, 5, 6, 7]", limits).find("21 bytes"), std::string::npos);
  EXPECT_NE(ErrorOf(std::string(1'000'000, '[')).find("64 deep"), std::string::npos);
  const test::TempFolder folder;
  EXPECT_EQ(
      JsonDocument::Read(folder.Write("a.json", "[1, 2, 3, 4, 5, 6, 7]"), limits).status().code(),
      absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(JsonDocument::Read(folder.Path("none.json")).status().code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace dynmesh::io
