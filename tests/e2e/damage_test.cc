// dynmeshd on a folder that was damaged while it did not run: meshes with losses are named in the
// log, in lists and by /readyz, and are read only; the others work; an operator continues.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/dynamic_mesh.h"
#include "proto/codec/status_codec.h"
#include "tests/e2e/daemon.h"
#include "tests/server/http/http_get.h"
#include "tests/support/temp_folder.h"

namespace dynmesh {
namespace {

namespace fs = std::filesystem;
using client::MeshClient;

class DamagedDaemonTest : public ::testing::Test {
 protected:
  std::string Data(const std::string& name = "") const { return folder_.path() + "/data" + name; }

  void Start(const std::string& accept = "") {
    std::vector<std::string> arguments = {"--data-dir", Data(), "--metrics", "127.0.0.1:0"};
    if (!accept.empty()) arguments.push_back("--accept-loss=" + accept);
    log_before_ = daemon_.Log().size();
    ASSERT_TRUE(daemon_.Start(arguments)) << daemon_.Log();
    client_ = MeshClient::Connect(daemon_.address());
  }
  void Kill() {
    client_.reset();
    daemon_.End(SIGKILL);
  }
  // Since the last start.
  std::string Log() const { return daemon_.Log().substr(log_before_); }
  std::string Ready() const {
    const std::string log = Log();
    const std::string mark = "event=metrics_listen address=";
    const std::size_t at = log.find(mark) + mark.size();
    const auto answer = server::HttpGet(log.substr(at, log.find('\n', at) - at), "/readyz");
    return absl::StrCat(answer.status, " ", answer.body);
  }
  absl::Status Add(const std::string& mesh, FeatureId id) {
    const double x = 0.01 * static_cast<double>(id);
    const bool space = mesh == "space";
    client::EditParams params;
    params.dimension = space ? 3 : 2;
    const Feature point = space ? Feature::Point(id, x, 0.5, 0.25) : Feature::Point(id, x, 0.5);
    return client_->Apply(mesh, {Edit::Add(point)}, params).status();
  }
  // Two meshes of 30 revisions each, in turn, all of it in the log.
  void Fill() {
    MeshOptions options;
    ASSERT_TRUE(client_->CreateMesh("flat", options).ok());
    options.dimension = 3;
    options.quality = 2;
    ASSERT_TRUE(client_->CreateMesh("space", options).ok());
    for (FeatureId id = 1; id <= 30; ++id) {
      for (const char* mesh : {"flat", "space"}) {
        const absl::Status s = Add(mesh, id);
        ASSERT_TRUE(s.ok()) << s;
      }
    }
  }
  // As listed: "id revision" for intact meshes, "id revision!" for read-only ones, "id!" for the
  // others.
  std::string List() {
    std::string text;
    const auto meshes = client_->ListMeshes();
    EXPECT_TRUE(meshes.ok()) << meshes.status();
    for (const client::MeshInfo& mesh : *meshes) {
      absl::StrAppend(&text, mesh.id);
      if (mesh.damage.empty() || mesh.read_only) absl::StrAppend(&text, " ", mesh.revision);
      absl::StrAppend(&text, mesh.damage.empty() ? "" : "!", "\n");
    }
    return text;
  }

  test::TempFolder folder_;
  test::Daemon daemon_{folder_.path()};
  std::size_t log_before_ = 0;
  std::unique_ptr<MeshClient> client_;
};

TEST_F(DamagedDaemonTest, AFlippedBitOfTheLogIsNamedAndAccepted) {
  Start();
  Fill();
  EXPECT_EQ(Ready(), "200 ready\n");
  Kill();
  {
    std::fstream log(Data("/journal.sqlite-wal"), std::ios::in | std::ios::out | std::ios::binary);
    const auto at = static_cast<std::streamoff>(fs::file_size(Data("/journal.sqlite-wal")) / 2);
    log.seekg(at);
    const char byte = static_cast<char>(log.get() ^ 4);
    log.seekp(at);
    log.put(byte);
  }
  Start();
  const auto flat = client_->GetMesh("flat"), space = client_->GetMesh("space");
  ASSERT_TRUE(flat.ok() && space.ok());
  EXPECT_LT(flat->revision, 30u);
  EXPECT_GT(flat->revision, 0u);
  EXPECT_EQ(List(), absl::StrCat("flat ", flat->revision, "!\nspace ", space->revision, "!\n"));
  EXPECT_EQ(Ready(), "200 ready; damaged meshes: 2\n");
  EXPECT_TRUE(absl::StrContains(Log(), "event=journal_log_damaged")) << Log();
  for (const auto& mesh : {*flat, *space}) {
    const std::string line = absl::StrCat("event=mesh_loss mesh=", mesh.id, " key=");
    const std::string rest = absl::StrCat(" acknowledged=30 found=", mesh.revision, " ");
    EXPECT_TRUE(absl::StrContains(Log(), line)) << Log();
    EXPECT_TRUE(absl::StrContains(Log(), rest)) << Log();
    const absl::Status refused = Add(mesh.id, 40);
    EXPECT_TRUE(absl::IsDataLoss(refused)) << refused;
    const auto error = codec::GetServiceError(refused);
    EXPECT_TRUE(error.has_value() && error->reason == codec::reason::kMeshDamaged) << refused;
    EXPECT_TRUE(client_->GetFeatures(mesh.id).ok());
  }
  ASSERT_TRUE(client_->CreateMesh("other", MeshOptions()).ok());
  EXPECT_TRUE(Add("other", 1).ok());
  Kill();
  Start(absl::StrCat("flat@", flat->revision));
  EXPECT_EQ(List(),
            absl::StrCat("flat ", flat->revision, "\nother 1\nspace ", space->revision, "!\n"));
  EXPECT_TRUE(Add("flat", 40).ok());
  ASSERT_TRUE(client_->DeleteMesh("space").ok());
  Kill();
  Start();
  EXPECT_EQ(List(), absl::StrCat("flat ", flat->revision + 1, "\nother 1\n"));
  EXPECT_EQ(Ready(), "200 ready\n");
}

TEST_F(DamagedDaemonTest, ALogThatIsGoneAndACopyWithoutItAreNamed) {
  Start();
  Fill();
  Kill();
  fs::copy(Data(), Data("2"));
  for (const char* file : {"/journal.sqlite-wal", "/journal.sqlite-shm"}) fs::remove(Data(file));
  Start();
  EXPECT_EQ(List(), "flat!\nspace!\n");
  EXPECT_EQ(Ready(), "200 ready; damaged meshes: 2\n");
  EXPECT_TRUE(absl::StrContains(Log(), "acknowledged=30 found=none")) << Log();
  EXPECT_TRUE(absl::StrContains(Log(), "event=journal_losses")) << Log();
  Kill();
  // Started, so that the log is in the database; then that is copied, without the record.
  fs::remove_all(Data());
  fs::rename(Data("2"), Data());
  Start();
  EXPECT_EQ(List(), "flat 30\nspace 30\n");
  client_.reset();
  EXPECT_EQ(daemon_.End(SIGTERM), 0);
  fs::copy(Data("/journal.sqlite"), folder_.path() + "/copy");
  fs::remove_all(Data());
  fs::create_directory(Data());
  fs::copy(folder_.path() + "/copy", Data("/journal.sqlite"));
  Start();
  EXPECT_EQ(List(), "flat 30!\nspace 30!\n");
  EXPECT_TRUE(absl::StrContains(Log(), "acknowledged=unknown found=30")) << Log();
  Kill();
  Start("flat@30,space@30");
  EXPECT_EQ(List(), "flat 30\nspace 30\n");
}

}  // namespace
}  // namespace dynmesh
