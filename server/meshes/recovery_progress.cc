#include "server/meshes/recovery_progress.h"

#include "server/base/log.h"

namespace dynmesh::server {

RecoveryProgress::RecoveryProgress(const std::vector<Journal::Mesh>& meshes,
                                   RecoveryMetrics* metrics)
    : metrics_(metrics), meshes_(meshes.size()) {
  for (const Journal::Mesh& mesh : meshes) entries_ += mesh.entries;
  if (metrics_ != nullptr) metrics_->entries.Set(static_cast<double>(entries_));
}

void RecoveryProgress::Apply() {
  entries_done_.fetch_add(1, std::memory_order_relaxed);
  if (metrics_ == nullptr) return;
  metrics_->entries_done.Add(1);
  metrics_->entries_done_total.Add();
}

void RecoveryProgress::Damage() {
  if (metrics_ != nullptr) metrics_->damaged.Add(1);
}

void RecoveryProgress::EndMesh() {
  // Notified under the lock: as soon as the waiting thread continues, this object may be destroyed.
  const MutexLock lock(mutex_);
  ++meshes_done_;
  ended_.NotifyAll();
}

void RecoveryProgress::Wait(absl::Duration interval) {
  const MutexLock lock(mutex_);
  while (!ended_.WaitFor(
      mutex_, absl::ToChronoMilliseconds(interval),
      [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return meshes_done_ == meshes_; })) {
    Log(LogLevel::kInfo, "recovering",
        {{"entries_done", entries_done_.load()},
         {"entries", entries_},
         {"meshes_done", meshes_done_},
         {"meshes", meshes_}});
  }
  if (metrics_ != nullptr) metrics_->seconds.Set(SecondsSince(start_));
}

}  // namespace dynmesh::server
