// What is too large, or refused in many places, ends soon, with an error that helps.
#include <filesystem>
#include <sstream>
#include <string>

#include "gtest/gtest.h"
#include "tests/client/cli/command_line.h"
#include "tests/support/count_of.h"

namespace dynmesh::cli {
namespace {

using test::CountOf;

class CommandLimits : public CommandLineFixture {
 protected:
  // Pairs of segments that cross.
  void WriteCrossings(int count) const {
    std::ostringstream points, segments;
    points << 4 * count << " 2 0 0\n";
    segments << 2 * count << " 0\n";
    for (int i = 0; i < count; ++i) {
      const int x = 10 * i, p = 4 * i;
      points << p + 1 << ' ' << x << " 0\n" << p + 2 << ' ' << x + 4 << " 4\n";
      points << p + 3 << ' ' << x << " 4\n" << p + 4 << ' ' << x + 4 << " 0\n";
      segments << 2 * i + 1 << ' ' << p + 1 << ' ' << p + 2 << "\n";
      segments << 2 * i + 2 << ' ' << p + 3 << ' ' << p + 4 << "\n";
    }
    folder_.Write("x.poly", points.str() + segments.str() + "0\n");
  }
};

TEST_F(CommandLimits, TheSearchForRefusalsEndsAfterTen) {
  WriteCrossings(12);
  const Outcome ten = Run("mesh --exact x.poly");
  EXPECT_EQ(ten.code, 2);
  EXPECT_EQ(CountOf(ten.err, "cross at"), 10U);
  EXPECT_NE(ten.err.find("at least 10 refusals: the search ended there, --all looks on"),
            std::string::npos)
      << ten.err;
  const Outcome all = Run("mesh --exact x.poly --all");
  EXPECT_EQ(CountOf(all.err, "cross at"), 10U);
  EXPECT_NE(all.err.find("12 refusals, the first 10 told"), std::string::npos) << all.err;
  // With fewer there is nothing to look on for.
  WriteCrossings(3);
  EXPECT_EQ(Run("mesh --exact x.poly").err, Run("mesh --exact x.poly --all").err);
  EXPECT_NE(Run("mesh --exact x.poly").err.find("warning: 3 refusals\n"), std::string::npos);
}

// Points are kept in another form while a mesh is made of many.
TEST_F(CommandLimits, OfManyPointsTooManyVerticesAreRefused) {
  std::ostringstream points;
  points << 2500 << " 2 0 0\n";
  for (int i = 0; i < 2500; ++i) {
    // Two in the middle are close to each other.
    const double x = i == 1225 ? 24 : i % 50, y = i == 1225 ? 24.00001 : i / 50;
    points << i + 1 << ' ' << x << ' ' << y << '\n';
  }
  folder_.Write("p.node", points.str());
  const Outcome limited = Run("mesh p.node --max-vertices 2600 -o m.node");
  EXPECT_EQ(limited.code, 1);
  EXPECT_NE(limited.err.find("max_vertices = 2600"), std::string::npos) << limited.err;
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("m.node")));
  EXPECT_EQ(Run("mesh p.node -o m.node").code, 0);
  EXPECT_EQ(Run("verify m.node --input p.node").code, 0);
}

TEST_F(CommandLimits, MemoryEndsAMeshWithAnError) {
  folder_.Write("s.node", "4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n");
  // The process alone takes some megabytes; this mesh takes hundreds.
  const Outcome outcome = Run("mesh s.node --hmax 0.0015 --max-memory 100M -o m.node");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("0.105 GB of memory"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("--max-memory"), std::string::npos) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("m.node")));
  // It would have more vertices than fit: that is known at once.
  const Outcome bound = Run("mesh s.node --hmax 0.0001 --max-memory 100M");
  EXPECT_EQ(bound.code, 1);
  EXPECT_NE(bound.err.find("takes at least"), std::string::npos) << bound.err;
  EXPECT_NE(bound.err.find("is what fits into 0.105 GB of memory; --max-memory allows more"),
            std::string::npos)
      << bound.err;
  EXPECT_EQ(Run("mesh s.node --hmax 0.1 --max-memory 1G").code, 0);
  for (const std::string bad : {"x", "0", "-1", "1X", "1MB", "nan", "1e30"}) {
    const Outcome refused = Run("mesh s.node --max-memory " + bad);
    EXPECT_EQ(refused.code, 2) << bad;
    EXPECT_NE(refused.err.find("--max-memory"), std::string::npos) << refused.err;
  }
  // A script, revision by revision.
  folder_.Write("s.dynmesh",
                "mesh dim=2 box=0,0,1,1\nadd point 1 0.5 0.5\ncommit\n"
                "add size 2 disc 0.5 0.5 0.4 0.0012\ncommit\n");
  const Outcome replay = Run("replay s.dynmesh --max-memory 100M");
  EXPECT_EQ(replay.code, 1);
  EXPECT_NE(replay.err.find("of memory"), std::string::npos) << replay.err;
}

// The address space has a limit, as `ulimit -v` sets it: an error, no signal.
TEST_F(CommandLimits, AnAddressSpaceThatIsTooSmallIsAnError) {
  folder_.Write("s.node", "4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n");
  const std::string command = "cd '" + folder_.Path("") +
                              "' && bash -c \"ulimit -v 400000; '" DYNMESH_BINARY
                              "' mesh s.node --hmax 0.00098\" > out.txt 2> err.txt";
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1) << folder_.Read("err.txt");
  EXPECT_NE(folder_.Read("err.txt").find("GB of memory"), std::string::npos)
      << folder_.Read("err.txt");
}

TEST_F(CommandLimits, TheDefaultLimitOfVerticesGoesWithTheInput) {
  const std::string gap = "4 2 0 0\n1 0 0\n2 1 0\n3 0 6e-8\n4 1 6e-8\n2 0\n1 1 2\n2 3 4\n0\n";
  folder_.Write("g.poly", gap);
  const Outcome few = Run("mesh --exact g.poly --max-memory 100G");
  EXPECT_EQ(few.code, 1);
  EXPECT_NE(few.err.find("max_vertices = 2000000 is the default of `mesh`"), std::string::npos)
      << few.err;
  // The user's own is no default.
  const Outcome own = Run("mesh --exact g.poly --max-vertices 6000000 --max-memory 100G");
  EXPECT_EQ(own.code, 1);
  EXPECT_EQ(own.err.find("is the default"), std::string::npos) << own.err;
}

}  // namespace
}  // namespace dynmesh::cli
