// --unsplit, and the judge's view of what stays whole.
#include <string>

#include "gtest/gtest.h"
#include "tests/client/cli/command_line.h"

namespace dynmesh::cli {
namespace {

class UnsplitFlag : public CommandLineFixture {
 protected:
  void SetUp() override {
    folder_.Write(
        "p.poly",
        "5 2 0 0\n1 0 0\n2 8 0\n3 8 8\n4 0 8\n5 4 4\n4 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n0\n");
  }
};

TEST_F(UnsplitFlag, WholeBordersAreJudged) {
  const Outcome split = Run("mesh p.poly --hmax 1 --json"),
                whole = Run("mesh p.poly --hmax 1 --unsplit 6,9 -o m.node --json");
  ASSERT_EQ(whole.code, 0) << whole.err;
  EXPECT_NE(Value(split.out, "hash"), Value(whole.out, "hash"));
  EXPECT_EQ(split.out.find("exempt_by_unsplit"), std::string::npos);
  EXPECT_EQ(Value(whole.out, "exempt_by_unsplit"), Value(whole.out, "exempt"));
  const std::string judged = "verify m.node --input p.poly --unsplit ";
  EXPECT_EQ(Run(judged + "6,9").code, 0);
  EXPECT_EQ(Run(judged + "all").code, 1);  // the other two are split
}

TEST_F(UnsplitFlag, AllMeansSegmentsAndPolygons) {
  const Outcome all = Run("mesh p.poly --unsplit all --json"),
                each = Run("mesh p.poly --unsplit 6,7,8,9 --json");
  ASSERT_EQ(all.code, 0) << all.err;
  EXPECT_EQ(Value(all.out, "hash"), Value(each.out, "hash"));
}

TEST_F(UnsplitFlag, BadOnesAreRefused) {
  for (const char* ids : {"5", "10", "x", "6,", "6,5"}) {
    const Outcome outcome = Run(std::string("mesh p.poly --unsplit ") + ids);
    EXPECT_EQ(outcome.code, 2) << ids;
    EXPECT_NE(outcome.err.find("no id of a segment or a polygon"), std::string::npos) << ids;
  }
  EXPECT_EQ(Run("mesh p.poly --unsplit all --engine svr").code, 2);
}

}  // namespace
}  // namespace dynmesh::cli
