// A host with a scripted journal, and jobs for it that are one group.
#ifndef DYNMESH_TESTS_SERVER_MESHES_EDIT_GROUP_FIXTURE_H_
#define DYNMESH_TESTS_SERVER_MESHES_EDIT_GROUP_FIXTURE_H_

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynmesh/dynamic_mesh.h"
#include "server/base/log.h"
#include "tests/server/meshes/scripted_journal.h"
#include "tests/server/test_support.h"

namespace dynmesh::server {

inline absl::Status DiskFull() { return absl::UnavailableError("the disk is full"); }

class EditGroupTest : public HostFixture {
 protected:
  EditGroupTest() {
    EXPECT_TRUE(SetLogLevel("off").ok());
    // The grouping must not depend on the machine's speed.
    options_.turn = {1000, std::chrono::hours(1)};
    options_.long_batch = std::chrono::hours(1);
  }
  ~EditGroupTest() override {
    gate_->Release();
    journal_.Release();
    snapshots_->Stop();
    writers_.Stop();  // before the journal goes
  }

  std::shared_ptr<MeshHost> MakeHostOf(std::unique_ptr<DynamicMesh> mesh) {
    return MakeHostOf(std::move(mesh), snapshots_);
  }
  std::shared_ptr<MeshHost> MakeHostOf(std::unique_ptr<DynamicMesh> mesh,
                                       const std::shared_ptr<Snapshots>& snapshots) {
    MeshHost::Past past;
    options_.snapshots = snapshots;
    past.log = std::make_unique<MeshLog>(&journal_, 1, "m", 2, MeshLog::Sizes(), options_.compact);
    return MeshHost::Create("m", std::move(mesh), absl::UnixEpoch(), &writers_, &readers_, options_,
                            std::move(past));
  }
  std::shared_ptr<MeshHost> MakeHost() { return MakeHostOf(*MakeFake(MeshOptions(), gate_)); }

  static EditJob Job(EditBatch edits, std::string request_id = "") {
    EditJob job;
    job.edits = std::move(edits);
    job.request_id = std::move(request_id);
    return job;
  }
  // Has the number `answers_.size()` + the number in progress; its outcome carries it.
  void Hand(MeshHost& host, EditJob job) {
    job.done = [this, number = handed_++](Result outcome) {
      answers_.Put({number, std::move(outcome)});
    };
    host.ApplyUnbounded(std::move(job));
  }
  // The next answer, which has to be that of the next batch.
  Result Next() {
    auto [number, outcome] = answers_.Take();
    EXPECT_EQ(number, answered_++);
    return std::move(outcome);
  }
  // Submits all while the first waits, so that they are one group except for those that must not
  // be.
  void HandAll(MeshHost& host, std::vector<EditJob> jobs) {
    const auto begun = std::make_shared<Mailbox<int>>(), go = std::make_shared<Mailbox<int>>();
    // Before the first of them, even if it is refused at once.
    ASSERT_TRUE(host.Locate({}, nullptr,
                            [begun, go](const auto&) {
                              begun->Put(0);
                              go->Take();
                            })
                    .ok());
    begun->Take();
    for (EditJob& job : jobs) Hand(host, std::move(job));
    go->Put(0);
  }
  static void ExpectHead(const MeshHost& host, std::uint64_t revision,
                         const std::vector<FeatureId>& points) {
    EXPECT_EQ(host.head().revision, revision);
    EXPECT_EQ(host.head().hash, HashOfFake(points));
    EXPECT_EQ(host.stats().features, points.size());
    EXPECT_EQ((*host.store()->Latest())->vertices.size(), points.size());
  }
  void ExpectJournalFailed(const Result& result) {
    EXPECT_EQ(ReasonOf(result.status()), codec::reason::kJournalFailed) << result.status();
    EXPECT_EQ(result.status().code(), absl::StatusCode::kUnavailable);
  }

  MeshHost::Options options_;
  ScriptedJournal journal_;
  const std::shared_ptr<Snapshots> snapshots_ = std::make_shared<Snapshots>(&journal_);
  Mailbox<std::pair<int, Result>> answers_;
  int handed_ = 0, answered_ = 0;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_MESHES_EDIT_GROUP_FIXTURE_H_
