// A registry of fake meshes with a journal in a folder, that can end, crash and restart.
#ifndef DYNMESH_TESTS_SERVER_JOURNAL_DURABLE_REGISTRY_H_
#define DYNMESH_TESTS_SERVER_JOURNAL_DURABLE_REGISTRY_H_

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/journal/sqlite_journal.h"
#include "server/meshes/mesh_registry.h"
#include "tests/server/fake_dynamic_mesh.h"
#include "tests/server/test_support.h"

namespace dynmesh::server {

class DurableRegistry {
 public:
  using Result = absl::StatusOr<EditOutcome>;

  // The folder outlives it.
  explicit DurableRegistry(const std::string& folder, const ServerConfig& config = {},
                           const char* vfs = nullptr,
                           const std::vector<std::string>& accept_loss = {}) {
    SqliteJournal::Options options;
    options.accept_loss = accept_loss;
    options.vfs = vfs;
    auto journal = SqliteJournal::Open(folder, options);
    status_ = journal.status();
    if (!status_.ok()) return;
    journal_ = *std::move(journal);
    registry_ = std::make_unique<MeshRegistry>(
        config, [](const MeshOptions& o, const ApplyOptions&) { return MakeFake(o); }, &writers_,
        &readers_, journal_.get());
    status_ = registry_->Recover();
  }

  const absl::Status& status() const { return status_; }
  MeshRegistry& operator*() { return *registry_; }
  MeshRegistry* operator->() { return registry_.get(); }
  Journal& journal() { return *journal_; }
  std::shared_ptr<MeshHost> Host(const std::string& id = "m") {
    return *registry_->Find(MeshName(id));
  }

  Result Apply(EditBatch edits, const std::string& request_id = "", const std::string& id = "m") {
    const auto host = registry_->Find(MeshName(id));
    if (!host.ok()) return host.status();
    Mailbox<Result> box;
    EditJob job;
    job.edits = std::move(edits);
    job.request_id = request_id;
    job.done = [&box](Result outcome) { box.Put(std::move(outcome)); };
    if (absl::Status s = (*host)->Apply(std::move(job)); !s.ok()) return s;
    Result result = box.Take();
    // What the strand does after an answer, too, is done when it is through the next task; then the
    // snapshot that it ordered is made.
    Mailbox<int> idle;
    EXPECT_TRUE((*host)->Locate({}, nullptr, [&](const auto&) { idle.Put(0); }).ok());
    idle.Take();
    registry_->WaitForSnapshots();
    return result;
  }

 private:
  absl::Status status_;
  std::unique_ptr<Journal> journal_;
  WorkerPool writers_{2};
  WorkerPool readers_{2};
  std::unique_ptr<MeshRegistry> registry_;
};

// The files as a crash at this moment would leave them.
inline void CopyJournal(const std::string& from, const std::string& to) {
  for (const std::string file : {"/journal.sqlite", "/journal.sqlite-wal", "/journal.heads"}) {
    if (std::filesystem::exists(from + file)) std::filesystem::copy(from + file, to + file);
  }
}

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_JOURNAL_DURABLE_REGISTRY_H_
