#include "server/meshes/mesh_readers.h"

#include <utility>

#include "server/base/log.h"

namespace dynmesh::server {

std::shared_ptr<MeshReaders> MeshReaders::Create(std::string id,
                                                 std::shared_ptr<RevisionStore> store,
                                                 std::optional<MeshHistory> history,
                                                 const MeshStats& stats, WorkerPool* pool,
                                                 const WatchHub::Options& watch) {
  return std::shared_ptr<MeshReaders>(
      new MeshReaders(std::move(id), std::move(store), std::move(history), stats, pool, watch));
}

MeshReaders::MeshReaders(std::string id, std::shared_ptr<RevisionStore> store,
                         std::optional<MeshHistory> history, const MeshStats& stats,
                         WorkerPool* pool, const WatchHub::Options& watch)
    : id_(std::move(id)),
      pool_(pool),
      store_(std::move(store)),
      hub_(WatchHub::Create(store_, pool, watch)),
      history_(std::move(history)),
      stats_(stats) {}

MeshReaders::~MeshReaders() { hub_->Close(absl::UnavailableError("the mesh was closed")); }

absl::Status MeshReaders::Append(const std::shared_ptr<const MeshDiff>& diff,
                                 const MeshStats& stats) {
  if (absl::Status status = store_->Append(diff); !status.ok()) return status;
  const MutexLock lock(mutex_);
  stats_ = stats;
  return absl::OkStatus();
}

void MeshReaders::Notify() {
  hub_->Notify();
  RebaseIfDue();
}

void MeshReaders::RebaseIfDue() {
  if (!store_->wants_rebase() || rebasing_.exchange(true)) return;
  pool_->Post([self = shared_from_this()] {
    const auto latest = self->store_->Latest();
    self->rebasing_.store(false);
    if (!latest.ok()) {
      Log(LogLevel::kError, "snapshot_failed",
          {{"mesh", self->id_}, {"error", latest.status().message()}});
    }
  });
}

void MeshReaders::Close(const absl::Status& status) {
  {
    const MutexLock lock(mutex_);
    closed_ = status;
  }
  ended_ = true;
  waiters_.Close();
  hub_->Close(status);
}

absl::Status MeshReaders::closed() const {
  const MutexLock lock(mutex_);
  return closed_;
}

MeshStats MeshReaders::stats() const {
  const MutexLock lock(mutex_);
  return stats_;
}

void MeshReaders::FeaturesAtRevision(std::optional<std::uint64_t> revision,
                                     std::shared_ptr<const std::atomic<bool>> cancelled,
                                     std::function<void(absl::StatusOr<FeaturesAt>)> done) {
  pool_->Post([self = shared_from_this(), revision, cancelled = std::move(cancelled),
               done = std::move(done)] {
    const Head head = self->head();
    done(self->history_->At(revision.value_or(head.revision), head, cancelled.get()));
  });
}

void MeshReaders::WhenAt(std::uint64_t revision, RevisionWaiters::Clock::time_point end,
                         RevisionWaiters::Done done) {
  waiters_.Add(revision, end, std::move(done));
  TellWaiters();  // it may have come before
}

}  // namespace dynmesh::server
