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

namespace dynmesh::cli::remote_history_test {
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

// A script's markers and names come out of every command as they went in.
TEST_F(RemoteHistoryTest, LabelsGoFromScriptsToWatchesAndFiles) {
  const std::vector<std::string> keep = {"--data-dir", folder_.path() + "/data"};
  ASSERT_TRUE(daemon_.Start(keep)) << daemon_.Log();
  const std::string script = folder_.Write(
      "s.dynmesh",
      "mesh box=0,0,4,4\nadd point 1 0 0\nadd point 2 4 0\nadd point 3 4 4\nadd point 4 0 4\n"
      "add segment 5 1 2\nadd segment 6 2 3\nadd polygon 9 1 2 3 4\nname 5 Inlet of \"gas\"\n"
      "name 6 Wall\nname 9 Plate\nmarker 5 42\n");
  const Ran applied = Remote({"apply", "plate", script, "--create", "--json"});
  ASSERT_EQ(applied.code, kExitDone) << applied.err;
  EXPECT_EQ(applied.err, "") << "nothing is left out";
  const std::string all =
      "\"labels\": [{\"id\": \"5\", \"marker\": 42, \"name\": \"Inlet of \\\"gas\\\"\"}, "
      "{\"id\": \"6\", \"marker\": 0, \"name\": \"Wall\"}, "
      "{\"id\": \"9\", \"marker\": 0, \"name\": \"Plate\"}]";
  EXPECT_NE(applied.out.find(all), std::string::npos) << applied.out;

  // Labels alone: a revision without a change of the mesh.
  const std::string more = folder_.Write("m.dynmesh", "marker 1 7\nname 1 Corner\nmarker 6 0\n");
  const Ran changed = Remote({"apply", "plate", more, "--json"});
  ASSERT_EQ(changed.code, kExitDone) << changed.err;
  EXPECT_NE(changed.out.find("\"added_simplices\": 0, \"removed_simplices\": 0"), std::string::npos)
      << changed.out;
  EXPECT_NE(changed.out.find("{\"id\": \"6\", \"marker\": 0, \"name\": \"\"}"), std::string::npos)
      << changed.out;
  const Ran words = Remote({"apply", "plate", folder_.Write("w.dynmesh", "name 6 Wall\n")});
  EXPECT_NE(words.out.find(", labels 1\n"), std::string::npos) << words.out;

  // The features are a script with the same labels, after a restart, too.
  EXPECT_EQ(daemon_.End(SIGTERM), 0);
  ASSERT_TRUE(daemon_.Start(keep)) << daemon_.Log();
  const std::string again = folder_.path() + "/again.dynmesh";
  ASSERT_EQ(Remote({"features", "plate", "-o", again}).code, kExitDone);
  ASSERT_EQ(Remote({"load", "copy", again, "--create"}).code, kExitDone);
  ASSERT_EQ(Remote({"apply", "other", again, "--create", "--quiet"}).code, kExitDone);
  EXPECT_EQ(Remote({"features", "copy"}).out, Remote({"features", "plate"}).out);
  EXPECT_EQ(Remote({"features", "other"}).out, Remote({"features", "plate"}).out);
  EXPECT_NE(Remote({"features", "plate"}).out.find("marker 1 7\nname 1 Corner\n"),
            std::string::npos);
  const Ran past = Remote({"features", "plate", "--revision", "2"});
  EXPECT_EQ(past.out.find("Wall"), std::string::npos) << past.out;

  // Files are those that `mesh` writes of the script.
  for (const std::string markers : {"ids", "input"}) {
    std::vector<std::string> mesh = {"mesh", again, "--markers", markers},
                             exported = {"export", "plate", "--markers", markers},
                             watched = {"watch", "plate", "--until", "3", "--markers", markers};
    const std::vector<std::string> extensions = {".msh", ".vtu", ".mesh", ".node"};
    for (const std::string& extension : extensions) {
      for (const auto& [name, command] :
           {std::pair{"a", &mesh}, std::pair{"b", &exported}, std::pair{"c", &watched}}) {
        command->insert(command->end(), {"-o", folder_.path() + "/" + name + extension});
      }
    }
    ASSERT_EQ(RunDynmesh(mesh).code, kExitDone);
    const Ran written = Remote(exported);
    ASSERT_EQ(written.code, kExitDone) << written.err;
    ASSERT_EQ(Remote(watched).code, kExitDone);
    for (const std::string& extension : extensions) {
      const std::string wanted = folder_.Read("a" + extension);
      EXPECT_EQ(folder_.Read("b" + extension), wanted) << markers << extension;
      EXPECT_EQ(folder_.Read("c" + extension), wanted) << markers << extension;
    }
    if (markers == "ids") {
      EXPECT_NE(folder_.Read("b.msh").find("\"Wall\""), std::string::npos);
    }
  }
  const Ran told = Remote({"watch", "plate", "--until", "3", "--json"});
  EXPECT_NE(told.out.find("{\"id\": \"1\", \"marker\": 7, \"name\": \"Corner\"}"),
            std::string::npos)
      << told.out;
  EXPECT_EQ(Remote({"export", "plate", "--markers", "some", "-o", folder_.path() + "/x.msh"}).code,
            kExitBadInput);

  // What is wrong is named with its line.
  const Ran absent = Remote({"apply", "plate", folder_.Write("b.dynmesh", "\nmarker 77 1\n")});
  EXPECT_EQ(absent.code, kExitBadInput);
  EXPECT_NE(absent.err.find("b.dynmesh:2: cannot label feature 77"), std::string::npos)
      << absent.err;
  const std::string long_name = "name 1 " + std::string(256, 'n') + "\n";
  const Ran bad = Remote({"apply", "plate", folder_.Write("l.dynmesh", long_name)});
  EXPECT_EQ(bad.code, kExitBadInput);
  EXPECT_NE(bad.err.find("l.dynmesh:1: the name of feature 1"), std::string::npos) << bad.err;
}

}  // namespace
}  // namespace dynmesh::cli::remote_history_test
