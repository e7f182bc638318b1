// Files beside a mesh's, and the guard of the input's base name.
#include <algorithm>
#include <filesystem>
#include <sstream>
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

// Enough for several blocks of rows and of compressed bytes.
TEST_F(Outputs, BytesDoNotDependOnThreads) {
  const std::vector<std::string> names = {".node", ".ele", ".edge", ".vtu", ".msh"};
  const std::string flags = " -q 25 -a 0.0005 -o ";
  for (const std::string threads : {"1", "2", "5"}) {
    const std::string stem = "t" + threads;
    const Outcome done = Run("mesh p.poly --json --threads " + threads + flags + stem +
                             ".node -o " + stem + ".vtu -o " + stem + ".msh");
    ASSERT_EQ(done.code, 0) << done.err;
    for (const std::string& name : names) {
      EXPECT_TRUE(folder_.Read(stem + name) == folder_.Read("t1" + name)) << threads << name;
    }
  }
  EXPECT_GT(std::filesystem::file_size(folder_.Path("t1.edge")), 1'000'000U);
  EXPECT_EQ(Run("verify t5.node").code, 0);  // the hash in it, too
  EXPECT_EQ(Run("mesh p.poly --threads 0 -o n.node").code, 2);
}

TEST_F(Outputs, BytesOfAMshAreTheSameMesh) {
  ASSERT_EQ(Run("mesh p.poly -q 30 -a 0.01 -o a.msh").code, 0);
  for (const std::string version : {"4.1", "2.2"}) {
    ASSERT_EQ(Run("mesh p.poly -q 30 -a 0.01 -o b.msh --binary --msh-version " + version).code, 0);
    EXPECT_EQ(folder_.Read("b.msh").substr(12, 5), version + " 1");
    EXPECT_EQ(Run("diff a.msh b.msh").code, 0);
  }
}

TEST_F(Outputs, AreOpenedAlongCracks) {
  folder_.Write(
      "c.dynmesh",
      "mesh dim=2 box=0,0,2,1 hmax=0.2\nadd point 1 0 0\nadd point 2 2 0\nadd point 3 2 1\n"
      "add point 4 0 1\nadd point 5 0.5 0.5\nadd point 6 1 0.5\nadd point 7 1.5 0.6\n"
      "add polygon 10 1 2 3 4\nadd segment 20 5 6\nadd segment 21 6 7\ncommit\n");
  ASSERT_EQ(Run("mesh c.dynmesh --region 10 -o closed.node").code, 0);
  const std::string crack = " c.dynmesh --region 10 --open 20,21 -o ";
  ASSERT_EQ(Run("mesh" + crack + "open.node").code, 0);
  ASSERT_EQ(Run("replay" + crack + "again.node").code, 0);
  const auto rows = [&](const std::string& name) { return std::stoi(folder_.Read(name)); };
  EXPECT_EQ(rows("open.ele"), rows("closed.ele"));
  // As many vertices more as are between the tips, and a second row of edges.
  const int more = rows("open.node") - rows("closed.node");
  EXPECT_GT(more, 2);
  EXPECT_EQ(rows("open.edge"), rows("closed.edge") + more + 1);
  EXPECT_EQ(rows("again.node"), rows("open.node"));
  for (const std::string wrong : {"--open 20", "--region 10 --open 22", "--region 10 --open x",
                                  "--region 10 --inside --open 20"}) {
    const Outcome refused = Run("mesh c.dynmesh -o x.node " + wrong);
    EXPECT_EQ(refused.code, 2) << wrong;
    EXPECT_NE(refused.err.find("--open"), std::string::npos) << refused.err;
  }
}

TEST_F(Outputs, OfEachFormatOfMeshesAreCompared) {
  ASSERT_EQ(Run("mesh p.poly -o a.node -o a.vtu -o a.msh -o a.mesh").code, 0);
  ASSERT_EQ(Run("mesh p.poly -q 30 -a 0.01 -o b.node -o b.vtu -o b.msh -o b.mesh").code, 0);
  for (const std::string extension : {".node", ".vtu", ".msh", ".mesh"}) {
    EXPECT_EQ(Run("diff a" + extension + " a" + extension).code, 0) << extension;
    EXPECT_EQ(Run("diff a" + extension + " b" + extension).code, 1) << extension;
  }
  EXPECT_EQ(Run("diff p.poly b.csv").code, 2);
}

// The value of an attribute behind `from`, split at semicolons.
std::vector<std::string> ValuesOf(const std::string& text, const std::string& attribute,
                                  std::size_t from) {
  const std::size_t begin = text.find(" " + attribute + "=\"", from) + attribute.size() + 3;
  std::vector<std::string> values;
  std::istringstream in(text.substr(begin, text.find('"', begin) - begin));
  for (std::string value; std::getline(in, value, ';');) values.push_back(value);
  return values;
}

// In each frame of an animation, the triangles that show are as many as the revision's mesh has,
// and the orange ones as many as it added.
TEST_F(Outputs, AnimationsShowEachRevision) {
  std::string script = "mesh dim=2 box=0,0,8,8\nadd point 1 2 2\nadd point 2 6 3\ncommit\n";
  for (int step = 0; step < 6; ++step) {
    script += "add point " + std::to_string(10 + step) + " " + std::to_string(1 + step) + " 5\n" +
              (step == 2   ? "add segment 5 1 2\n"
               : step == 4 ? "remove 5\n"
                           : "") +
              "commit\n";
  }
  folder_.Write("s.dynmesh", script);
  const Outcome ran = Run("replay s.dynmesh --json --animation a.svg --animate-from 2 --crop all");
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto number = [](const std::string& line, const std::string& key) {
    return std::stoul(line.substr(line.find("\"" + key + "\": ") + key.size() + 4));
  };
  const std::string svg = folder_.Read("a.svg");
  constexpr std::size_t kFrames = 6;
  std::vector<std::size_t> shown(kFrames, 0), orange(kFrames, 0), segments(kFrames, 0);
  const auto value_at = [](const std::vector<std::string>& values,
                           const std::vector<std::string>& times, std::size_t frame) {
    std::string value;
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (std::stod(times[i]) * kFrames < static_cast<double>(frame) + 0.5) value = values[i];
    }
    return value;
  };
  for (const std::string& line : Lines(svg)) {
    if (!line.starts_with("<path")) continue;
    const std::string path = ValuesOf(line, "d", 0)[0];
    const auto closed = static_cast<std::size_t>(std::count(path.begin(), path.end(), 'z'));
    for (std::size_t frame = 0; frame < kFrames; ++frame) {
      const auto at = [&](const std::string& attribute) {
        const std::size_t animation = line.find("attributeName=\"" + attribute + "\"");
        if (animation == std::string::npos) {
          return line.find("visibility=\"hidden\"") == std::string::npos ? "visible" : "hidden";
        }
        return value_at(ValuesOf(line, "values", animation), ValuesOf(line, "keyTimes", animation),
                        frame) == (attribute == "fill" ? "#f6a821" : "visible")
                   ? "visible"
                   : "hidden";
      };
      if (std::string(at("visibility")) != "visible") continue;
      shown[frame] += closed;
      if (closed == 0) ++segments[frame];
      const bool is_new = line.find("attributeName=\"fill\"") != std::string::npos;
      if (is_new && std::string(at("fill")) == "visible") orange[frame] += closed;
    }
  }
  const std::vector<std::string> revisions = Lines(ran.out);
  for (std::size_t frame = 0; frame < kFrames; ++frame) {
    const std::string& line = revisions[frame + 1];
    EXPECT_EQ(shown[frame], number(line, "simplices")) << frame;
    if (frame == 0) continue;  // what was there
    EXPECT_EQ(orange[frame], number(line, "added_simplices")) << frame;
    EXPECT_EQ(segments[frame] > 0, frame >= 2 && frame < 4) << frame;
  }
  folder_.Write("space.dynmesh", "mesh dim=3 box=0,0,0,8,8,8\nadd point 1 2 2 2\ncommit\n");
  EXPECT_EQ(Run("replay space.dynmesh --animation a.svg").code, 2);
  EXPECT_EQ(Run("replay s.dynmesh --animation a.png").code, 2);
  EXPECT_EQ(Run("replay s.dynmesh --animation a.svg --animate-from 8").code, 2);
}

TEST_F(Outputs, ClipsAreOf3D) {
  EXPECT_EQ(Run("mesh p.poly -o m.svg --clip z=1").code, 2);
  folder_.Write("space.dynmesh", "mesh dim=3 box=0,0,0,8,8,8\nadd point 1 2 2 2\ncommit\n");
  EXPECT_EQ(Run("mesh space.dynmesh -o m.svg --clip z=1 --cut z=1").code, 2);
  EXPECT_EQ(Run("mesh space.dynmesh -o m.svg --clip w=1").code, 2);
  ASSERT_EQ(Run("mesh space.dynmesh -o m.svg --clip z --fill size --legend --crop all").code, 0);
  EXPECT_NE(folder_.Read("m.svg").find("clipped at z = 4<"), std::string::npos);
}

}  // namespace
}  // namespace dynmesh::cli
