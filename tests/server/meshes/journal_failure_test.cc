// Meshes on a failing disk: only durable changes are acknowledged, and no acknowledged change is
// lost.
#include <gtest/gtest.h>

#include <vector>

#include "absl/strings/str_cat.h"
#include "server/base/log.h"
#include "tests/server/journal/durable_registry.h"
#include "tests/server/journal/failing_vfs.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server::journal_failure_test {
namespace {

using absl::StatusCode;

class JournalFailureTest : public ::testing::Test {
 protected:
  JournalFailureTest() { EXPECT_TRUE(SetLogLevel("off").ok()); }
  ~JournalFailureTest() override { FailingVfs::Heal(); }

  void Open() {
    server_.reset();
    server_ = std::make_unique<DurableRegistry>(folder_.path(), config_, FailingVfs::Name());
    ASSERT_TRUE(server_->status().ok()) << server_->status();
  }

  test::TempFolder folder_;
  ServerConfig config_;
  std::unique_ptr<DurableRegistry> server_;
};

TEST_F(JournalFailureTest, AnEditThatCannotBeWrittenIsUndoneAndReadersAreServed) {
  Open();
  ASSERT_TRUE((*server_)->Create("m", MeshOptions(), "").ok());
  ASSERT_TRUE(server_->Apply({AddPoint(1)}, "r1").ok());
  const auto host = server_->Host();
  const Head head = host->head();
  FailingVfs::FailAt(1, /*ever=*/true);
  for (int i = 0; i < 2; ++i) {
    const absl::Status refused = server_->Apply({AddPoint(2)}, "r2").status();
    EXPECT_EQ(refused.code(), StatusCode::kUnavailable) << refused;
    EXPECT_EQ(ReasonOf(refused), codec::reason::kJournalFailed);
    EXPECT_TRUE(codec::GetServiceError(refused)->retry_after.has_value());
    EXPECT_EQ(host->head().revision, head.revision);
    EXPECT_EQ(host->head().hash, head.hash);
    EXPECT_EQ(host->stats().features, 1u);
    EXPECT_EQ((*host->store()->Latest())->vertices.size(), 1u);
    // What needs no writing goes on.
    EXPECT_TRUE(server_->Apply({AddPoint(1)}, "r1")->replayed);
    EXPECT_TRUE(server_->Apply({}).ok());
  }
  EXPECT_GE(server_->journal().counts().failures, 2u);
  EXPECT_EQ(ReasonOf((*server_)->Create("n", MeshOptions(), "").status()),
            codec::reason::kJournalFailed);
  EXPECT_EQ(ReasonOf((*server_)->Find("meshes/n").status()), codec::reason::kMeshNotFound);
  EXPECT_EQ(ReasonOf((*server_)->Delete("meshes/m")), codec::reason::kJournalFailed);
  EXPECT_TRUE((*server_)->Find("meshes/m").ok());

  FailingVfs::Heal();
  const auto result = server_->Apply({AddPoint(2)}, "r2");
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_FALSE(result->replayed);
  EXPECT_EQ(result->diff->to_revision, 2u);
  EXPECT_TRUE((*server_)->Create("n", MeshOptions(), "").ok());
  EXPECT_TRUE((*server_)->Delete("meshes/m").ok());
}

TEST_F(JournalFailureTest, AnEditOfAMeshThatIsDeletedMeanwhileIsRefused) {
  Open();
  ASSERT_TRUE((*server_)->Create("m", MeshOptions(), "").ok());
  // Deleted in the journal, not yet closed: as for an edit that comes between the two.
  ASSERT_TRUE(server_->journal().Delete(server_->journal().List()->front().key).ok());
  EXPECT_EQ(ReasonOf(server_->Apply({AddPoint(1)}).status()), codec::reason::kMeshDeleted);
  EXPECT_EQ(server_->Host()->head().revision, 0u);
}

TEST_F(JournalFailureTest, ASnapshotThatCannotBeWrittenCostsNoEdit) {
  config_.compact_bytes = 0;
  Open();
  ASSERT_TRUE((*server_)->Create("m", MeshOptions(), "").ok());
  for (int at = 1; at < 8; ++at) {
    const auto id = static_cast<FeatureId>(at);
    FailingVfs::FailAt(at, /*ever=*/false);
    const bool ok = server_->Apply({AddPoint(id)}).ok();
    FailingVfs::Heal();
    if (!ok) {
      ASSERT_TRUE(server_->Apply({AddPoint(id)}).ok());
    }
  }
  const Head head = server_->Host()->head();
  Open();
  EXPECT_EQ(server_->Host()->head().revision, 7u);
  EXPECT_EQ(server_->Host()->head().hash, head.hash);
}

// A script of edits with one write after the other failing, once or for good.
class FailAtEveryWrite : public JournalFailureTest, public ::testing::WithParamInterface<bool> {
 protected:
  // After a crash now: the acknowledged changes, possibly with the last refused batch.
  void ExpectAfterCrash(const std::vector<FeatureId>& acknowledged, FeatureId refused) {
    test::TempFolder copy;
    CopyJournal(folder_.path(), copy.path());
    DurableRegistry crashed(copy.path());
    ASSERT_TRUE(crashed.status().ok()) << crashed.status();
    const auto host = crashed->Find("meshes/m");
    ASSERT_TRUE(host.ok()) << host.status();
    const Head head = (*host)->head();
    std::vector<FeatureId> expected = acknowledged;
    if (head.revision != acknowledged.size()) expected.push_back(refused);
    ASSERT_EQ(head.revision, expected.size());
    EXPECT_EQ(head.hash, HashOfFake(expected));
    ASSERT_TRUE(refused != kNoFeature || expected.size() == acknowledged.size());
  }

  // True if something failed.
  bool Run(int at) {
    std::filesystem::remove_all(folder_.path());
    config_.compact_bytes = 250;
    Open();
    EXPECT_TRUE((*server_)->Create("m", MeshOptions(), "").ok());
    FailingVfs::FailAt(at, GetParam());
    std::vector<FeatureId> acknowledged, refused;
    for (FeatureId id = 1; id <= 8; ++id) {
      const auto result = server_->Apply({AddPoint(id)}, absl::StrCat("r", id));
      if (result.ok()) {
        acknowledged.push_back(id);
      } else {
        EXPECT_EQ(ReasonOf(result.status()), codec::reason::kJournalFailed) << result.status();
        refused.push_back(id);
      }
      EXPECT_EQ(server_->Host()->head().revision, acknowledged.size());
      EXPECT_EQ(server_->Host()->head().hash, HashOfFake(acknowledged));
      if (!result.ok() || id % 4 == 0) ExpectAfterCrash(acknowledged, result.ok() ? 0 : id);
      if (HasFailure()) return false;
    }
    FailingVfs::Heal();
    for (const FeatureId id : refused) {
      const auto retried = server_->Apply({AddPoint(id)}, absl::StrCat("r", id));
      EXPECT_TRUE(retried.ok() && !retried->replayed) << retried.status();
      acknowledged.push_back(id);
    }
    ExpectAfterCrash(acknowledged, kNoFeature);
    return FailingVfs::failures() > 0;
  }
};

TEST_P(FailAtEveryWrite, EveryAcknowledgedEditIsThereAndNoneByHalf) {
  int at = 1;
  while (Run(at) && !HasFailure()) ++at;
  EXPECT_FALSE(HasFailure()) << "with operation " << at << " failing";
  EXPECT_GT(at, 25);
}

INSTANTIATE_TEST_SUITE_P(OnceAndForGood, FailAtEveryWrite, ::testing::Bool());

}  // namespace
}  // namespace dynmesh::server::journal_failure_test
