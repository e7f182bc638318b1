#include "core/io/common/text_reader.h"

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "core/io/common/file_writer.h"
#include "gtest/gtest.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

void ExpectReadsBack(double value) {
  double back = 42;
  ASSERT_TRUE(ParseDouble(FormatDouble(value), &back)) << FormatDouble(value);
  ASSERT_EQ(std::bit_cast<std::uint64_t>(back), std::bit_cast<std::uint64_t>(value));
}

TEST(Numbers, EveryFiniteDoubleReadsBackBitForBit) {
  const std::uint64_t seed = test::NewSeed();
  std::mt19937_64 random(seed);
  int finite = 0;
  for (int i = 0; i < 300'000; ++i) {
    const double value = std::bit_cast<double>(random());
    if (!std::isfinite(value)) continue;
    ++finite;
    ExpectReadsBack(value);
  }
  EXPECT_GT(finite, 290'000);
  for (int i = 0; i < 10'000; ++i) {  // subnormal ones
    ExpectReadsBack(std::bit_cast<double>(random() >> 12));
    ExpectReadsBack(-std::bit_cast<double>(random() >> 60));
  }
  using Limits = std::numeric_limits<double>;
  for (const double value : {0.0, -0.0, Limits::min(), Limits::max(), Limits::denorm_min(),
                             -Limits::max(), 0.1, 1.0 / 3, 1e22, 1e23}) {
    ExpectReadsBack(value);
  }
}

// Of any size: read at once, in blocks, or both.
TEST(ReadWholeFile, HasEveryByte) {
  const test::TempFolder folder;
  std::mt19937_64 random(7);
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, std::size_t{255}, std::size_t{256}, std::size_t{300'000},
        (std::size_t{1} << 24) - 1, std::size_t{1} << 24, (std::size_t{1} << 24) + 300'000}) {
    std::string bytes(size, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    const auto read = ReadWholeFile(folder.Write("file", bytes));
    ASSERT_TRUE(read.ok());
    EXPECT_TRUE(*read == bytes) << size;
  }
  // Without a size, as a pipe.
  const auto read = ReadWholeFile("/proc/self/status");
  ASSERT_TRUE(read.ok());
  EXPECT_NE(read->find("VmPeak"), std::string::npos);
  EXPECT_FALSE(ReadWholeFile(folder.Path("none")).ok());
  EXPECT_FALSE(ReadWholeFile(folder.Path("")).ok());
}

TEST(Numbers, MinusZeroKeepsItsSign) { EXPECT_EQ(FormatDouble(-0.0), "-0"); }

TEST(Numbers, OnlyWholeFiniteNumbersAreTaken) {
  double value = 7;
  for (const char* bad :
       {"",         "+",     "-",      "x",    "1x", "1 ",   " 1",  "nan", "inf", "-inf",
        "infinity", "1e400", "-1e400", "0x10", "1e", "1..2", "+-1", "--1", "1,5", "1d5"}) {
    EXPECT_FALSE(ParseDouble(bad, &value)) << bad;
  }
  EXPECT_EQ(value, 7);
  EXPECT_TRUE(ParseDouble("+1.5E+2", &value));
  EXPECT_EQ(value, 150);
  EXPECT_TRUE(ParseDouble(".5", &value));
  EXPECT_EQ(value, 0.5);
  EXPECT_TRUE(ParseDouble("5.", &value));
  EXPECT_EQ(value, 5);
}

TEST(Numbers, IdsNeedAll64Bits) {
  std::uint64_t value = 7;
  EXPECT_TRUE(ParseUint64("18446744073709551615", &value));
  EXPECT_EQ(value, ~std::uint64_t{0});
  for (const char* bad : {"18446744073709551616", "-1", "1.0", "", "1e3", "0x1"}) {
    EXPECT_FALSE(ParseUint64(bad, &value)) << bad;
  }
}

TEST(TextReader, SplitsLinesAndDropsComments) {
  TextReader reader("f", "\xef\xbb\xbf# head\n\n  a\tb  # tail\r\n#\nc#d\r\n   \nlast");
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.tokens(), (std::vector<std::string_view>{"a", "b"}));
  EXPECT_EQ(reader.line(), 3);
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.tokens(), (std::vector<std::string_view>{"c"}));
  EXPECT_EQ(reader.line(), 5);
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.tokens(), (std::vector<std::string_view>{"last"}));
  EXPECT_EQ(reader.line(), 7);
  EXPECT_FALSE(reader.Next());
  EXPECT_FALSE(reader.Next());
  EXPECT_EQ(reader.line(), 7);
}

TEST(TextReader, KeepsItsTokensWhenMoved) {
  TextReader reader("f", "abc");  // short: would live inside a std::string
  ASSERT_TRUE(reader.Next());
  const TextReader moved = std::move(reader);
  EXPECT_EQ(moved.token(0), "abc");
}

TEST(TextReader, CollectsNotes) {
  TextReader reader("f", "1 # dynmesh one two \r\n# dynmesh three\n# other\n");
  while (reader.Next()) {
  }
  EXPECT_EQ(reader.notes(), (std::vector<std::string>{"one two", "three"}));
}

TEST(TextReader, SaysWhereAndWhat) {
  TextReader reader("dir/f.node", "\n 1 x\n");
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.Double(1, "y").status().message(),
            "dir/f.node:2: y is not a finite number within a double's range: 'x'");
  EXPECT_EQ(reader.Double(2, "z").status().message(), "dir/f.node:2: z is missing");
  EXPECT_EQ(reader.Uint64(1, "id").status().message(),
            "dir/f.node:2: id is not a whole number from 0 to 2^64 - 1: 'x'");
}

TEST(TextReader, NamesTheFileItCannotRead) {
  const test::TempFolder folder;
  const absl::Status missing = TextReader::Open(folder.Path("none")).status();
  EXPECT_EQ(missing.code(), absl::StatusCode::kNotFound);
  EXPECT_NE(missing.ToString().find(folder.Path("none")), std::string::npos);
  EXPECT_EQ(TextReader::Open(folder.Path("")).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(TextReader, TakesALineOfNumbersOrLeavesIt) {
  TextReader reader("f", "1 2.5\t-3 \r\n  2 1e3 4\n3 4 5 # end\n4 +1 6\n5 inf 7\n6 0x 8\n7 9 -9");
  const auto take = [&](std::uint64_t number, double value, std::int64_t marker) {
    return reader.TakeNext([&](NumberCursor& row) {
      std::uint64_t n = 0;
      double v = 0;
      std::int64_t m = 0;
      return row.Take(&n) && row.Take(&v) && row.Take(&m) && n == number && v == value &&
             m == marker;
    });
  };
  EXPECT_FALSE(reader.TakeNext([](NumberCursor& row) {
    double v = 0;
    return row.Take(&v) && row.Take(&v);
  })) << "there is one more";
  EXPECT_TRUE(take(1, 2.5, -3));
  EXPECT_EQ(reader.line(), 1);
  EXPECT_EQ(reader.size(), 0U);
  EXPECT_TRUE(take(2, 1000, 4));
  EXPECT_FALSE(take(3, 4, 5)) << "a comment";
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.line(), 3);
  EXPECT_EQ(reader.size(), 3U);
  EXPECT_FALSE(take(4, 1, 6)) << "a plus";
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.token(1), "+1");
  for (const int line : {5, 6}) {
    EXPECT_FALSE(reader.TakeNext([](NumberCursor& row) {
      double v = 0;
      return row.Take(&v) && row.Take(&v) && row.Take(&v);
    }));
    ASSERT_TRUE(reader.Next());
    EXPECT_EQ(reader.line(), line);
  }
  EXPECT_TRUE(take(7, 9, -9)) << "without a line's end";
  EXPECT_FALSE(reader.TakeNext([](NumberCursor& row) {
    double v = 0;
    return row.Take(&v);
  }));
  EXPECT_FALSE(reader.Next());
}

}  // namespace
}  // namespace dynmesh::io
