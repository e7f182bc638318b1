// Progress of the recovery of the journal's meshes, for the log and the metrics. Several meshes are
// recovered concurrently; one thread waits for all and logs the progress. Thread-safe.
#ifndef DYNMESH_SERVER_MESHES_RECOVERY_PROGRESS_H_
#define DYNMESH_SERVER_MESHES_RECOVERY_PROGRESS_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/journal/journal.h"
#include "server/metrics/server_metrics.h"

namespace dynmesh::server {

class RecoveryProgress {
 public:
  // `metrics` may be null.
  RecoveryProgress(const std::vector<Journal::Mesh>& meshes, RecoveryMetrics* metrics);

  void Apply();    // a snapshot or an entry is applied
  void Damage();   // a mesh turned out to be damaged
  void EndMesh();  // recovered or damaged

  // Blocks until all meshes have ended. Logs done and total once per interval.
  void Wait(absl::Duration interval);

 private:
  RecoveryMetrics* const metrics_;
  const MetricsClock::time_point start_ = MetricsClock::now();
  const std::size_t meshes_;
  std::uint64_t entries_ = 0;
  std::atomic<std::uint64_t> entries_done_{0};

  Mutex mutex_;
  CondVar ended_;
  std::size_t meshes_done_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_RECOVERY_PROGRESS_H_
