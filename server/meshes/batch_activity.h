// What a mesh's writer is doing, for observers: the batch that it applies; if it applies none, the
// first of the group that is being written to the journal. Thread-safe: one writer, any number of
// observers.
#ifndef DYNMESH_SERVER_MESHES_BATCH_ACTIVITY_H_
#define DYNMESH_SERVER_MESHES_BATCH_ACTIVITY_H_

#include <cstddef>
#include <optional>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/meshes/batch_progress.h"
#include "server/meshes/edit_job.h"
#include "server/metrics/server_metrics.h"

namespace dynmesh::server {

class BatchActivity {
 public:
  struct Running {
    std::size_t edits = 0;
    BatchProgress progress;
  };

  // By the writer. A job lives until the end.
  void BeginApply(const EditJob& job) {
    const MutexLock lock(mutex_);
    apply_ = Begun(job, {});
  }
  void SetProgress(const BatchProgress& progress);
  void EndApply() {
    const MutexLock lock(mutex_);
    apply_.job = nullptr;
  }
  void BeginAppend(const EditJob& job) {
    const MutexLock lock(mutex_);
    append_ = Begun(job, BatchProgress::Journal());
  }
  void EndAppend() {
    const MutexLock lock(mutex_);
    append_.job = nullptr;
  }
  // By the writer, while it applies a batch: for how long. Needs no lock: the writer alone writes
  // what it reads here.
  MetricsClock::duration applying() const ABSL_NO_THREAD_SAFETY_ANALYSIS {
    return MetricsClock::now() - apply_.since;
  }

  std::optional<Running> running() const;
  // Logs the batch if it has run for more than `interval`; at most once per interval. `features` is
  // the mesh's number of them, `waiting` that of the tasks behind the batch.
  void ReportLongWork(absl::Duration interval, absl::string_view mesh, std::uint64_t features,
                      std::size_t waiting);

 private:
  struct Activity {
    const EditJob* job = nullptr;
    BatchProgress progress;
    MetricsClock::time_point since;
    MetricsClock::time_point reported;  // or since
  };

  static Activity Begun(const EditJob& job, const BatchProgress& progress) {
    const auto now = MetricsClock::now();
    return {&job, progress, now, now};
  }

  mutable Mutex mutex_;
  Activity apply_ ABSL_GUARDED_BY(mutex_), append_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_BATCH_ACTIVITY_H_
