// `dynmesh features` and `revert` against a dynmeshd process.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "client/cli/command.h"
#include "client/cli/remote/connection.h"
#include "core/io/script/edit_script.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/e2e/daemon.h"
#include "tests/e2e/run_dynmesh.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::cli {
namespace {

constexpr char kScript[] =
    "mesh dim=2 box=0,0,1,1 rho=1.25 hmax=0.5\n"
    "add point 1 0.2 0.2\nadd point 2 0.8 0.2\nadd point 4 0.5 0.7\nadd segment 3 1 2\ncommit\n"
    "add polygon 7 1 2 4\nadd size 8 disc 0.5 0.5 0.125 0.05\ncommit\n"
    "remove 7\nremove 8\nmove point 4 0.5 0.8\nremove 3\n";

class RemoteHistoryTest : public ::testing::Test {
 protected:
  Ran Remote(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--server", daemon_.address()});
    return RunDynmesh(std::move(arguments));
  }
  // The hash of the mesh that a script makes.
  static std::string HashOf(const std::string& path) {
    const auto script = io::ReadEditScript(path);
    EXPECT_TRUE(script.ok()) << script.status();
    auto mesh = *DynamicMesh::Create(script->Options());
    for (const io::ScriptBatch& batch : script->batches) {
      EXPECT_TRUE(mesh->Apply(batch.edits).ok());
    }
    return mesh->hash().ToHex();
  }

  test::TempFolder folder_;
  test::Daemon daemon_{folder_.path()};
};

TEST(MeshLineTest, OfADamagedMeshSaysWhy) {
  client::MeshInfo mesh;
  mesh.id = "m";
  mesh.damage = "is damaged: \"why\"";
  EXPECT_EQ(MeshLine(mesh, /*json=*/false), "m  DAMAGED  is damaged: \"why\"\n");
  EXPECT_EQ(MeshLine(mesh, /*json=*/true),
            "{\"mesh\": \"m\", \"damage\": \"is damaged: \\\"why\\\"\"}\n");
}

TEST_F(RemoteHistoryTest, FeaturesAreAScriptOfTheSameMeshAndRevertGoesBack) {
  ASSERT_TRUE(daemon_.Start({"--data-dir", folder_.path() + "/data"})) << daemon_.Log();
  const std::string script = folder_.path() + "/s.dynmesh", out = folder_.path() + "/o.dynmesh";
  std::ofstream(script) << kScript;
  const Ran applied = Remote({"apply", "plate", script, "--create", "--one-by-one"});
  ASSERT_EQ(applied.code, kExitDone) << applied.err;
  std::vector<std::string> hashes;
  for (const char* revision : {"0", "1", "2", "3"}) {
    const Ran features = Remote({"features", "plate", "--revision", revision, "-o", out, "--json"});
    ASSERT_EQ(features.code, kExitDone) << features.err;
    hashes.push_back(HashOf(out));
    EXPECT_NE(features.out.find(hashes.back()), std::string::npos) << features.out;
  }
  const Ran present = Remote({"features", "plate"});
  EXPECT_EQ(present.out.rfind("mesh dim=2 ", 0), 0u) << present.out;
  EXPECT_NE(present.out.find("add point 4 0.5 0.8\n"), std::string::npos) << present.out;

  const Ran reverted = Remote({"revert", "plate", "2", "--json"});
  ASSERT_EQ(reverted.code, kExitDone) << reverted.err;
  EXPECT_NE(reverted.out.find("\"revision\": 4,"), std::string::npos) << reverted.out;
  EXPECT_NE(reverted.out.find(hashes[2]), std::string::npos) << reverted.out;
  const Ran words = Remote({"revert", "plate", "3"});
  EXPECT_EQ(words.out, "revision 5 is as revision 3, hash " + hashes[3] + "\n");
  EXPECT_NE(Remote({"revert", "plate", "9"}).code, kExitDone);
  EXPECT_NE(Remote({"revert", "plate", "1", "--expect", "2"}).code, kExitDone);
}

}  // namespace
}  // namespace dynmesh::cli
