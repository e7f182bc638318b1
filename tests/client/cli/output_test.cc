// Files beside a mesh's, and the guard of the input's base name.
#include <filesystem>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/client/cli/command_line.h"

namespace dynmesh::cli {
namespace {

class Outputs : public CommandLineFixture {
 protected:
  void SetUp() override {
    folder_.Write("p.poly", "3 2 0 0\n1 0 0\n2 4 0\n3 0 4\n3 0\n1 1 2\n2 2 3\n3 3 1\n0\n");
  }
  bool Has(const std::string& name) const { return std::filesystem::exists(folder_.Path(name)); }
};

TEST_F(Outputs, FilesOfTheInputsBaseNameAreRefusedUnlessAskedFor) {
  const std::string folder = std::filesystem::path(folder_.path()).filename().string();
  const std::vector<std::string> names = {"p.node", "./p.ele", "p.poly",
                                          "../" + folder + "/p.edge"};
  for (const std::string& name : names) {
    const Outcome refused = Run("mesh p.poly -o " + name);
    EXPECT_EQ(refused.code, 2) << name;
    EXPECT_NE(refused.err.find("belong to the input p.poly"), std::string::npos) << refused.err;
  }
  EXPECT_FALSE(Has("p.ele"));
  EXPECT_EQ(Run("mesh p.poly -o p.vtu -o p.msh -o p.1.node").code, 0);
  EXPECT_EQ(Run("mesh p.poly -o p.node --same-name").code, 0);
  EXPECT_TRUE(Has("p.ele"));
}

TEST_F(Outputs, CompanionsAreWrittenOnRequest) {
  ASSERT_EQ(Run("mesh p.poly --inside -o m.node").code, 0);
  EXPECT_FALSE(Has("m.neigh") || Has("m.v.node") || Has("m.poly"));
  ASSERT_EQ(Run("mesh p.poly --inside -o m.poly --neighbors --voronoi --zero-based").code, 0);
  EXPECT_TRUE(Has("m.neigh") && Has("m.v.node") && Has("m.v.edge") && Has("m.poly"));
  EXPECT_TRUE(folder_.Read("m.poly").starts_with("0 2 0 1\n"));
  // What was written is input.
  EXPECT_EQ(Run("mesh m.poly --inside -o again.node").code, 0);
  EXPECT_EQ(Run("mesh p.poly -o m.smesh").code, 2);
  EXPECT_EQ(Run("mesh p.poly -o m.mesh --order 2").code, 2);
  EXPECT_EQ(Run("mesh p.poly -o m.msh --order 3").code, 2);
  EXPECT_EQ(Run("mesh p.poly -o m.msh -o m.vtu -o m.node -o m.svg --order 2").code, 0);
}

}  // namespace
}  // namespace dynmesh::cli
