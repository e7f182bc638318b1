// Validation, limits and cancelling say what verdicts.txt records, word by word, and every reason
// of error.h is in it.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/golden/golden_verdicts.h"
#include "tests/support/source_path.h"

namespace dynmesh::test {
namespace {

// The lines of the file without comments.
std::vector<std::string> RecordedVerdicts() {
  std::vector<std::string> lines;
  std::ifstream file(test::SourcePath("tests/golden/verdicts.txt"));
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line[0] != '#') lines.push_back(line);
  }
  return lines;
}

TEST(GoldenVerdicts, AreThoseRecorded) {
  const std::vector<std::string> recorded = RecordedVerdicts(), now = VerdictLines();
  for (std::size_t i = 0; i < std::min(recorded.size(), now.size()); ++i) {
    EXPECT_EQ(now[i], recorded[i]) << "line " << i + 1 << ", comments not counted";
  }
  EXPECT_EQ(now.size(), recorded.size());
}

TEST(GoldenVerdicts, HaveEveryReason) {
  std::ifstream file(test::SourcePath("core/include/dynmesh/error.h"));
  const std::string header{std::istreambuf_iterator<char>(file), {}};
  const std::vector<std::string> lines = RecordedVerdicts();
  const std::string before = "[] = \"";  // constexpr char kNotFinite[] = "NOT_FINITE";
  int count = 0;
  for (std::size_t at = header.find(before); at != std::string::npos;
       at = header.find(before, at + 1)) {
    ++count;
    const std::size_t from = at + before.size();
    const std::string name = header.substr(from, header.find('"', from) - from);
    // "case: CODE REASON features ..." or "case: CODE REASON: ..."
    EXPECT_TRUE(std::ranges::any_of(lines, [&](const std::string& line) {
      return line.find(" " + name + " ") != std::string::npos ||
             line.find(" " + name + ":") != std::string::npos;
    })) << name;
  }
  EXPECT_GT(count, 30);
}

}  // namespace
}  // namespace dynmesh::test
