// dynmeshd on a disk that hangs, and on one whose files are touched by others.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/e2e/daemon.h"
#include "tests/server/http/http_get.h"
#include "tests/support/temp_folder.h"

namespace dynmesh {
namespace {

namespace fs = std::filesystem;
using client::MeshClient;

class DiskTest : public ::testing::Test {
 protected:
  ~DiskTest() override { fs::remove(hang_); }

  void Start(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"--data-dir", data_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    ASSERT_TRUE(daemon_.Start(arguments)) << daemon_.Log();
    client_ = MeshClient::Connect(daemon_.address());
  }
  // Its syncs hang while the file hang_ is there.
  void StartHanging(const std::vector<std::string>& more) {
    setenv("LD_PRELOAD", HANGING_SYNC_LIBRARY, 1);
    setenv("DYNMESH_HANG_FILE", hang_.c_str(), 1);
    // It comes before a sanitizer's runtime, which minds.
    const char* const options = std::getenv("ASAN_OPTIONS");
    const std::string before = options != nullptr ? options : "";
    setenv("ASAN_OPTIONS", absl::StrCat(before, ":verify_asan_link_order=0").c_str(), 1);
    Start(more);
    unsetenv("LD_PRELOAD");
    unsetenv("DYNMESH_HANG_FILE");
    setenv("ASAN_OPTIONS", before.c_str(), 1);
  }
  std::string MetricsAddress() const {
    const std::string log = daemon_.Log(), mark = "event=metrics_listen address=";
    const std::size_t at = log.find(mark) + mark.size();
    return log.substr(at, log.find('\n', at) - at);
  }
  absl::Status Add(const std::string& mesh, FeatureId id) {
    const double x = 0.01 * static_cast<double>(id);
    return client_->Apply(mesh, {Edit::Add(Feature::Point(id, x, 0.5))}).status();
  }

  const test::TempFolder folder_;
  const std::string data_ = folder_.Path("data"), hang_ = folder_.Path("hang");
  test::Daemon daemon_{folder_.path()};
  std::unique_ptr<MeshClient> client_;
};

TEST_F(DiskTest, AServerWhoseDiskNeverAnswersEndsAndSaysSo) {
  StartHanging({"--drain-timeout", "0.2", "--metrics", "127.0.0.1:0"});
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  for (FeatureId id = 1; id <= 3; ++id) ASSERT_TRUE(Add("m", id).ok());
  std::ofstream(hang_) << "x";
  absl::Status waits;
  std::thread editor([&] { waits = Add("m", 4); });
  test::WaitUntil("the sync", [this] {
    const std::string text = server::HttpGet(MetricsAddress(), "/metrics").body;
    const std::string mark = "\ndynmesh_journal_oldest_write_seconds ";
    const std::size_t at = text.find(mark);
    return at != std::string::npos && std::stod(text.substr(at + mark.size())) > 0.2;
  });
  // Without the limit it would wait for the disk.
  EXPECT_EQ(daemon_.End(SIGTERM), 3);
  editor.join();
  EXPECT_FALSE(waits.ok());
  EXPECT_TRUE(absl::StrContains(daemon_.Log(), "level=error event=not_drained")) << daemon_.Log();
  fs::remove(hang_);
  Start();
  const auto mesh = client_->GetMesh("m");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_GE(mesh->revision, 3u);  // what was acknowledged
  EXPECT_LE(mesh->revision, 4u);
}

TEST_F(DiskTest, ASharedIndexThatIsCutEndsTheServerWhichSaysWhy) {
  Start();
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  for (FeatureId id = 1; id <= 3; ++id) ASSERT_TRUE(Add("m", id).ok());
  fs::resize_file(data_ + "/journal.sqlite-shm", 0);
  EXPECT_FALSE(Add("m", 4).ok());
  int status = 0;
  ASSERT_NO_THROW(status = test::WaitForEnd(daemon_.process()));
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGBUS) << status;
  daemon_.Forget();
  EXPECT_TRUE(absl::StrContains(
      daemon_.Log(), "level=error event=mapped_file_cut file=\"" + data_ + "/journal.sqlite-shm\""))
      << daemon_.Log();
  Start();
  const auto mesh = client_->GetMesh("m");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_GE(mesh->revision, 3u);
  EXPECT_TRUE(Add("m", 5).ok());
}

}  // namespace
}  // namespace dynmesh
