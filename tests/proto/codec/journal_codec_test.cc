// Records of a journal; what each reader makes of damaged ones is tests/fuzz's.
#include "proto/codec/journal_codec.h"

#include <gtest/gtest.h>

#include <string>

namespace dynmesh::codec {
namespace {

constexpr MeshHash kHash{0x0123456789abcdef, 0xfedcba9876543210};

std::string Entry() {
  return EncodeJournalEntry({Edit::Add(Feature::Point(1, 0.25, 0.5)), Edit::Remove(7)}, kHash, 2);
}

TEST(JournalCodec, TheHashIsReadWithoutTheRest) {
  EXPECT_EQ(*DecodeJournalHash(Entry()), kHash);
  EXPECT_EQ(*DecodeJournalHash(EncodeJournalEntry({}, kHash, 3)), kHash);
  const Feature features[] = {Feature::Point(1, 0.25, 0.5), Feature::Point(2, 0.5, 0.25)};
  for (const std::string& part : EncodeJournalSnapshot(features, kHash, 2)) {
    EXPECT_EQ(*DecodeJournalHash(part), kHash);
  }
}

TEST(JournalCodec, NoHashIsReadOfHalfARecord) {
  const std::string entry = Entry();
  int refused = 0;
  for (std::size_t size = 0; size < entry.size(); ++size) {
    const auto hash = DecodeJournalHash(entry.substr(0, size));
    if (!hash.ok()) {
      EXPECT_TRUE(absl::IsDataLoss(hash.status())) << hash.status();
      ++refused;
    } else {
      EXPECT_EQ(*hash, kHash) << "the bits after it are missing";
    }
  }
  EXPECT_GE(refused, static_cast<int>(entry.size()) - 3);
  EXPECT_TRUE(absl::IsDataLoss(DecodeJournalHash("no record").status()));
}

}  // namespace
}  // namespace dynmesh::codec
