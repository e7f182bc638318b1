#include "server/meshes/batch_activity.h"

#include "server/base/log.h"

namespace dynmesh::server {

void BatchActivity::SetProgress(const BatchProgress& progress) {
  const MutexLock lock(mutex_);
  apply_.progress = progress;
}

std::optional<BatchActivity::Running> BatchActivity::running() const {
  const MutexLock lock(mutex_);
  const Activity& activity = apply_.job != nullptr ? apply_ : append_;
  if (activity.job == nullptr) return std::nullopt;
  return Running{activity.job->edits.size(), activity.progress};
}

void BatchActivity::ReportLongWork(absl::Duration interval, absl::string_view mesh,
                                   std::uint64_t features, std::size_t waiting) {
  const auto now = MetricsClock::now();
  const MutexLock lock(mutex_);
  Activity& activity = apply_.job != nullptr ? apply_ : append_;
  if (activity.job == nullptr || absl::FromChrono(now - activity.reported) < interval) return;
  activity.reported = now;
  Log(LogLevel::kInfo, "edit_running",
      {{"mesh", mesh},
       {"call", activity.job->call_id},
       {"edits", activity.job->edits.size()},
       {"features", features},
       {"stage", NameOf(activity.progress.stage)},
       {"done", activity.progress.done},
       {"total", activity.progress.total},
       {"seconds", absl::ToInt64Seconds(absl::FromChrono(now - activity.since))},
       {"waiting", waiting}});
}

}  // namespace dynmesh::server
