// Names of labels: what is UTF-8, by an independent table.
#include "core/plc/labels.h"

#include <gtest/gtest.h>

#include <string>

#include "dynmesh/error.h"

namespace dynmesh::plc::labels_test {
namespace {

absl::Status Check(const std::string& name) { return CheckLabel(7, {0, name}, 3); }

std::string Encode(char32_t c) {
  std::string text;
  if (c < 0x80) return std::string(1, static_cast<char>(c));
  const int more = c < 0x800 ? 1 : c < 0x10000 ? 2 : 3;
  const int lead[] = {0, 0xc0, 0xe0, 0xf0};
  text += static_cast<char>(lead[more] | static_cast<int>(c >> (6 * more)));
  for (int i = more; i-- > 0;) text += static_cast<char>(0x80 | (c >> (6 * i) & 0x3f));
  return text;
}

TEST(LabelNames, EveryCharacterButControlsAndSurrogatesIsGood) {
  for (char32_t c = 0; c < 0x110000; c += c < 0x2000 ? 1 : 61) {
    const bool control = c < 0x20 || (c >= 0x7f && c < 0xa0);
    const bool surrogate = c >= 0xd800 && c < 0xe000;
    EXPECT_EQ(Check("a" + Encode(c) + "z").ok(), !control && !surrogate)
        << std::hex << static_cast<unsigned>(c);
  }
}

TEST(LabelNames, WhatIsNotUtf8IsRefused) {
  for (const char* name : {"\x80", "\xbf", "\xc0\x80", "\xc1\xbf", "\xc3", "\xc3(", "\xe0\x80\xaf",
                           "\xe2\x82", "\xe2(\xac", "\xf0\x80\x80\xaf", "\xf0\x9f\x98",
                           "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xfe", "\xff"}) {
    EXPECT_FALSE(Check(name).ok());
    EXPECT_FALSE(Check(std::string("ab") + name + "c").ok());
  }
  EXPECT_TRUE(Check("").ok());
  EXPECT_TRUE(Check("\xf0\x9f\x98\x80 \xe2\x82\xac").ok());
  EXPECT_FALSE(Check(std::string("a\0b", 3)).ok());
}

TEST(LabelNames, AreOf255BytesAtMost) {
  std::string name;
  while (name.size() < 254) name += "\xc3\xa4";
  EXPECT_TRUE(Check(name + "a").ok());
  EXPECT_FALSE(Check(name + "\xc3\xa4").ok());
  const absl::Status status = Check(name + "ab");
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  const ErrorDetail wanted{reason::kBadLabel, {7}, 3};
  EXPECT_EQ(GetErrorDetail(status), wanted);
}

}  // namespace
}  // namespace dynmesh::plc::labels_test
