// Meshes that a dynmeshd process makes and does not keep: for the client library, and for
// `dynmesh mesh --server`.
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <iterator>
#include <random>
#include <thread>

#include "dynmesh/client/mesh_client.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/e2e/daemon.h"
#include "tests/e2e/run_dynmesh.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::cli {
namespace {

std::string Contents(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class BuildByDaemonTest : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_.path() + "/" + name; }
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(Path(name)) << text;
    return Path(name);
  }
  // Of points, for Triangle.
  std::string WriteCloud(int count) const {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    std::string text = std::to_string(count) + " 2 0 0\n";
    for (int i = 1; i <= count; ++i) {
      text += std::to_string(i) + " " + std::to_string(unit(random)) + " " +
              std::to_string(unit(random)) + "\n";
    }
    return Write("cloud.node", text);
  }
  // The same files and, but for the time, the same text.
  void ExpectSameAsInProcess(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "mesh");
    const auto with = [&](std::vector<std::string> more) {
      more.insert(more.begin(), arguments.begin(), arguments.end());
      return RunDynmesh(std::move(more));
    };
    const auto hash_of = [](const Ran& ran) {
      return ran.out.substr(std::min(ran.out.size(), ran.out.find("hash")));
    };
    const Ran here = with({"-o", Path("here.vtu")});
    ASSERT_EQ(here.code, kExitDone) << here.err;
    const Ran there = with({"-o", Path("there.vtu"), "--server", daemon_.address()});
    ASSERT_EQ(there.code, kExitDone) << there.err;
    EXPECT_EQ(hash_of(there), hash_of(here));
    EXPECT_EQ(Contents(Path("there.vtu")), Contents(Path("here.vtu")));
    EXPECT_EQ(there.err, here.err);
  }

  test::TempFolder folder_;
  test::Daemon daemon_{folder_.path()};
};

TEST_F(BuildByDaemonTest, TheClientLibraryGetsTheMeshAndTheServerKeepsNone) {
  ASSERT_TRUE(daemon_.Start({"--data-dir", Path("data")})) << daemon_.Log();
  const auto client = client::MeshClient::Connect(daemon_.address());
  std::vector<Feature> features = {Feature::Polygon(9, {{1, 2, 3}}), Feature::Point(1, 0.2, 0.2),
                                   Feature::Point(2, 0.8, 0.3), Feature::Point(3, 0.5, 0.9),
                                   Feature::SizeDisc(7, 0.5, 0.5, 0.2, 0.01)};
  features[1].label = {7, "Inlet"};
  const auto expected = BuildMesh(features, MeshOptions());
  const auto mesh = client->BuildMesh(features, MeshOptions());
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->hash, expected->hash);
  EXPECT_EQ(mesh->vertices, expected->vertices);
  EXPECT_EQ(mesh->simplices, expected->simplices);
  EXPECT_EQ(mesh->regions, expected->regions);
  EXPECT_EQ(mesh->labels, (LabelColumn{{1, {7, "Inlet"}}}));
  EXPECT_TRUE(client->ListMeshes()->empty());
}

TEST_F(BuildByDaemonTest, TheCommandWritesTheFilesOfTheSameMesh) {
  ASSERT_TRUE(daemon_.Start()) << daemon_.Log();
  const std::string cloud = WriteCloud(2'000);
  ExpectSameAsInProcess({cloud, "--rho", "1.2"});
  ExpectSameAsInProcess({cloud, "--engine", "svr"});
  ExpectSameAsInProcess({cloud, "--kind", "quadtree"});
  const std::string block = Write("block.off",
                                  "OFF\n8 6 0\n0 0 0\n3 0 0\n3 2 0\n0 2 0\n0.1 0.2 1\n3.2 0.2 1\n"
                                  "3.1 2.1 1\n0 2.2 1\n4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n"
                                  "4 2 3 7 6\n4 3 0 4 7\n");
  ExpectSameAsInProcess({block});
  ExpectSameAsInProcess({block, "--min-dihedral", "20"});
  ExpectSameAsInProcess({block, "--min-dihedral", "20", "--surroundings"});
}

TEST_F(BuildByDaemonTest, TheCommandReportsErrorsAsInProcess) {
  ASSERT_TRUE(daemon_.Start()) << daemon_.Log();
  const std::string crossed = Write("crossed.poly",
                                    "4 2 0 0\n1 0 0\n2 1 1\n3 0 1\n4 1 0\n"
                                    "2 0\n1 1 2\n2 3 4\n0\n");
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"mesh", "--exact", crossed},
        {"mesh", WriteCloud(100), "--max-vertices", "50"},
        {"mesh", WriteCloud(100), "--rho", "1000"}}) {
    const Ran here = RunDynmesh(arguments);
    std::vector<std::string> remote = arguments;
    remote.insert(remote.end(), {"--server", daemon_.address()});
    const Ran there = RunDynmesh(remote);
    EXPECT_NE(there.code, kExitDone);
    EXPECT_EQ(there.code, here.code);
    EXPECT_EQ(there.err, here.err);
  }
  daemon_.End(SIGKILL);
  const Ran gone = RunDynmesh(
      {"mesh", "--exact", crossed, "--server", daemon_.address(), "--timeout", "5000ms"});
  EXPECT_EQ(gone.code, kExitFailed) << gone.err;
}

TEST_F(BuildByDaemonTest, ADrainEndsALongBuild) {
  ASSERT_TRUE(daemon_.Start({"--max-build-vertices", "100000000"})) << daemon_.Log();
  const auto client = client::MeshClient::Connect(daemon_.address());
  MeshOptions options;
  options.max_edge = 3e-4;
  client::BuildParams params;
  params.progress = [&, drained = false](const client::LoadProgress&) mutable {
    if (!std::exchange(drained, true)) daemon_.Signal(SIGTERM);
  };
  const absl::Status status = client->BuildMesh({}, options, params).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable) << status;
  EXPECT_EQ(daemon_.End(0), 0);
}

}  // namespace
}  // namespace dynmesh::cli
