#include "core/io/common/file_writer.h"

#include <sys/stat.h>

#include <filesystem>

#include "gtest/gtest.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

TEST(FileWriter, WritesNumbersAndText) {
  const test::TempFolder folder;
  FileWriter out(folder.Path("f"));
  out << "a" << ' ' << 1.5 << ' ' << -3 << ' ' << ~std::uint64_t{0} << ' ' << std::size_t{7}
      << '\n';
  ASSERT_TRUE(out.Close().ok());
  EXPECT_EQ(folder.Read("f"), "a 1.5 -3 18446744073709551615 7\n");
  EXPECT_EQ(folder.FileCount(), 1U);
}

TEST(FileWriter, LeavesTheOldFileUntilClosed) {
  const test::TempFolder folder;
  folder.Write("f", "old");
  {
    FileWriter out(folder.Path("f"));
    out << std::string(1 << 20, 'x');
    EXPECT_EQ(folder.Read("f"), "old");
  }
  EXPECT_EQ(folder.Read("f"), "old");
  EXPECT_EQ(folder.FileCount(), 1U);  // nothing left behind
  FileWriter out(folder.Path("f"));
  out << "new";
  EXPECT_TRUE(out.Finish().ok());
  EXPECT_EQ(folder.Read("f"), "old");
  EXPECT_TRUE(out.Close().ok());
  EXPECT_EQ(folder.Read("f"), "new");
}

TEST(FileWriter, WritesThroughALink) {
  const test::TempFolder folder;
  folder.Write("real", "old");
  std::filesystem::create_symlink("real", folder.Path("link"));
  FileWriter out(folder.Path("link"));
  out << "new";
  ASSERT_TRUE(out.Close().ok());
  EXPECT_EQ(folder.Read("real"), "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder.Path("link")));
}

TEST(FileWriter, NeverReplacesADevice) {
  FileWriter out("/dev/null");
  out << "text";
  EXPECT_TRUE(out.Close().ok());
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(FileWriter, NamesTheFileItCannotWrite) {
  const test::TempFolder folder;
  FileWriter out(folder.Path("no/such/folder/f"));
  out << "text";
  const absl::Status status = out.Close();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_NE(status.ToString().find("no/such/folder/f"), std::string::npos);
}

TEST(FileWriter, ReportsAFullDisk) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  FileWriter out("/dev/full");
  out << std::string(1 << 20, 'x');
  EXPECT_EQ(out.Close().code(), absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace dynmesh::io
