#include "core/io/common/parallel.h"

#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

TEST(TextBlock, HasTheTextOfAFileWriter) {
  const test::TempFolder folder;
  FileWriter out(folder.Path("f"));
  TextBlock text;
  const auto write = [](auto& to, int i) {
    to << i << ' ' << 0.1 * i << ' ' << std::pow(-1.7, i % 200) << std::string_view(" row ")
       << ~std::uint64_t{0} - static_cast<std::uint64_t>(i) << '\n';
  };
  for (int i = -50; i < 5000; ++i) write(out, i), write(text, i);
  ASSERT_TRUE(out.Close().ok());
  EXPECT_EQ(folder.Read("f"), text.text());
  text.Clear();
  EXPECT_EQ(text.text(), "");
}

std::string Written(std::size_t rows, int threads) {
  const test::TempFolder folder;
  FileWriter out(folder.Path("f"));
  out << "head\n";
  WriteRows(rows, threads, out, [](std::size_t i, TextBlock& text) {
    text << i;
    if (i % 1000 == 0) text << std::string(i / 50, 'x');  // blocks of different lengths
    text << '\n';
  });
  out << "end\n";
  EXPECT_TRUE(out.Close().ok());
  return folder.Read("f");
}

TEST(WriteRows, BytesDoNotDependOnThreads) {
  for (const std::size_t rows : {0, 1, 4095, 4096, 4097, 20'000, 100'001}) {
    const std::string expected = Written(rows, 1);
    EXPECT_TRUE(expected.starts_with("head\n") && expected.ends_with("end\n"));
    for (const int threads : {0, 2, 3, 8}) EXPECT_EQ(Written(rows, threads), expected);
  }
}

TEST(WriteBlocks, AnExceptionReachesTheCaller) {
  for (const int threads : {1, 2, 5}) {
    FileWriter out("/dev/null");
    const auto make = [](std::size_t i, TextBlock& text) {
      if (i == 40) throw std::runtime_error("no memory");
      text << i;
    };
    EXPECT_THROW(WriteBlocks(100, threads, out, make), std::runtime_error);
    EXPECT_THROW(ForEachBlock(100, threads,
                              [](std::size_t i) {
                                if (i == 40) throw std::runtime_error("no memory");
                              }),
                 std::runtime_error);
  }
}

TEST(WriteBlocks, AFileThatCannotBeWrittenIsAnErrorAtTheEnd) {
  FileWriter out("/dev/full");
  WriteRows(100'000, 2, out, [](std::size_t i, TextBlock& text) { text << i << '\n'; });
  EXPECT_FALSE(out.Close().ok());
}

TEST(ForEachBlock, DoesEachOnce) {
  for (const int threads : {0, 1, 2, 7}) {
    for (const std::size_t count : {0, 1, 5, 1000}) {
      std::vector<std::atomic<int>> done(count);
      ForEachBlock(count, threads, [&](std::size_t i) { ++done[i]; });
      for (const auto& times : done) EXPECT_EQ(times, 1);
    }
  }
}

}  // namespace
}  // namespace dynmesh::io
