// dynmeshd on journals that programs with other bits (kMeshBits) wrote: the real files.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "core/mesh_data/feature_set.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/e2e/daemon.h"
#include "tests/support/source_path.h"
#include "tests/support/temp_folder.h"

namespace dynmesh {
namespace {

namespace fs = std::filesystem;
using client::MeshClient;

// Mesh flat, revisions 1 to 6, with a snapshot of 5 and one entry after it; mesh space, revisions 1
// to 4, without a snapshot. bits1 is the folder after a kill, with the log and the record of the
// heads; bits1-backup.sqlite what VACUUM INTO makes of it. The tables are those of
// the oldest schema that is read, and the schema's number was set to it.
class JournalsOfOtherBits : public testing::TestWithParam<bool> {
 protected:
  static void CopyTo(const fs::path& data) {
    const fs::path journals = test::SourcePath("tests/e2e/journals");
    if (GetParam()) {
      fs::create_directory(data);
      fs::copy_file(journals / "bits1-backup.sqlite", data / "journal.sqlite");
    } else {
      fs::copy(journals / "bits1", data);
    }
  }
};

INSTANTIATE_TEST_SUITE_P(FolderAndBackup, JournalsOfOtherBits, testing::Bool());

TEST_P(JournalsOfOtherBits, GoOnAsTheNextRevision) {
  test::TempFolder folder;
  const std::string data = folder.path() + "/data";
  CopyTo(data);
  const auto scratch = [](const client::MeshInfo& info, const std::vector<Feature>& features) {
    auto mesh = *DynamicMesh::Create(info.options);
    EXPECT_TRUE(mesh->Apply(mesh_data::EditsBetween({}, features)).ok());
    return mesh->hash();
  };
  test::Daemon daemon(folder.path());
  ASSERT_TRUE(daemon.Start({"--data-dir", data})) << daemon.Log();
  const std::string log = daemon.Log();
  EXPECT_TRUE(absl::StrContains(
      log, absl::StrCat("event=bits_changed mesh=flat revision=7 from=1 to=", kMeshBits)))
      << log;
  EXPECT_TRUE(absl::StrContains(
      log, absl::StrCat("event=bits_changed mesh=space revision=5 from=1 to=", kMeshBits)));
  {
    const auto client = MeshClient::Connect(daemon.address());
    for (const auto& [id, revision] : {std::pair("flat", 7u), std::pair("space", 5u)}) {
      const auto info = client->GetMesh(id);
      ASSERT_TRUE(info.ok()) << info.status();
      EXPECT_EQ(info->revision, revision);
      EXPECT_EQ(info->options.min_dihedral, 0);  // as meshed by that version
      const auto present = client->GetFeatures(id);
      const auto before = client->GetFeatures(id, revision - 1);
      ASSERT_TRUE(present.ok() && before.ok());
      EXPECT_EQ(present->features, before->features);
      EXPECT_EQ(present->hash, info->hash);
      EXPECT_EQ(info->hash, scratch(*info, present->features));
    }
    EXPECT_EQ(client->GetFeatures("flat", 3)->features.size(), 8u);
    // The sizing feature makes lattice points, which other bits did not have.
    EXPECT_NE(client->GetFeatures("flat", 6)->hash, client->GetFeatures("flat", 7)->hash);
    const auto back = client->RevertTo("flat", 3);
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(back->diff.to_revision, 8u);
    EXPECT_EQ(back->diff.hash,
              scratch(*client->GetMesh("flat"), client->GetFeatures("flat", 3)->features));
  }
  const MeshHash head = MeshClient::Connect(daemon.address())->GetMesh("flat")->hash;
  daemon.End(SIGKILL);
  const std::size_t told = daemon.Log().size();
  ASSERT_TRUE(daemon.Start({"--data-dir", data})) << daemon.Log();
  const std::string again = daemon.Log().substr(told);
  EXPECT_FALSE(absl::StrContains(again, "bits_changed")) << again;
  const auto client = MeshClient::Connect(daemon.address());
  EXPECT_EQ(client->GetMesh("flat")->revision, 8u);
  EXPECT_EQ(client->GetMesh("flat")->hash, head);
  EXPECT_EQ(client->GetMesh("space")->revision, 5u);
}

}  // namespace
}  // namespace dynmesh
