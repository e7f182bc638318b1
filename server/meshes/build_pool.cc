#include "server/meshes/build_pool.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/codec/status_codec.h"
#include "server/base/log.h"
#include "server/meshes/batch_interrupt.h"

namespace dynmesh::server {
namespace {

using Clock = MetricsClock;

// Interruptions that may be missed between two looks at the clock: some hundred microseconds.
constexpr unsigned kStepsBetweenLooks = 64;

// The clock cannot count to the greatest durations.
Clock::time_point EndAfter(absl::Duration limit) {
  constexpr absl::Duration kYear = absl::Hours(24 * 365);
  if (limit > kYear) return Clock::time_point::max();
  return Clock::now() + absl::ToChronoNanoseconds(limit);
}

}  // namespace

BuildPool::BuildPool(const ServerConfig& config, MeshBuilder builder, const MemoryGuard* memory,
                     BuildMetrics* metrics)
    : builder_(std::move(builder)),
      max_operations_(config.max_batch_operations),
      max_time_(config.max_build_time),
      memory_(memory),
      metrics_(metrics),
      threads_(builder_ == nullptr ? 1 : static_cast<int>(config.max_builds),
               WorkerPool::Priority::kBackground) {}

void BuildPool::Post(BuildJob job) {
  auto shared = std::make_shared<BuildJob>(std::move(job));
  threads_.Post([this, shared] { Run(*shared); });
}

void BuildPool::Run(BuildJob& job) const {
  const std::size_t features = job.features.size();
  const auto start = Clock::now();
  metrics_->running.Add(1);
  absl::StatusOr<Mesh> mesh = Build(job);
  metrics_->Count(mesh.status(), SecondsSince(start));
  metrics_->running.Add(-1);
  std::vector<Feature>().swap(job.features);
  Log(LogLevel::kDebug, "build",
      {{"call", job.call_id},
       {"features", features},
       {"vertices", mesh.ok() ? mesh->vertices.size() : 0},
       {"seconds", SecondsSince(start)},
       {"status", absl::StatusCodeToString(mesh.status().code())},
       {"message", mesh.status().message()}});
  job.done(std::move(mesh));
}

absl::StatusOr<Mesh> BuildPool::Build(const BuildJob& job) const {
  if (absl::Status status = memory_->CheckRoom(); !status.ok()) return status;
  bool is_late = false;
  BuildOptions build;
  build.engine = job.engine;
  build.only_inside = job.only_inside;
  build.max_operations = max_operations_;
  build.interrupted = [&is_late, interrupted = BatchInterrupt(job.stopped.get(), memory_->full()),
                       end = EndAfter(job.max_time), steps = 0u]() mutable {
    if (++steps % kStepsBetweenLooks == 0 && Clock::now() >= end) is_late = true;
    return is_late || interrupted();
  };
  if (job.progress != nullptr) {
    build.progress = [&job](const ApplyProgress& progress) { job.progress(progress); };
  }
  absl::StatusOr<Mesh> mesh = builder_(job.features, job.options, build);
  if (!absl::IsCancelled(mesh.status())) return mesh;
  if (job.stopped != nullptr && job.stopped->load(std::memory_order_relaxed)) return mesh;
  return is_late ? TimeLimitError(job.max_time) : memory_->RefuseGrowth();
}

absl::Status BuildPool::TimeLimitError(absl::Duration limit) const {
  codec::ServiceError error;
  error.reason = codec::reason::kTimeLimit;
  error.field = "max_time";
  const bool is_servers = limit == max_time_;
  return codec::MakeServiceError(
      absl::StatusCode::kResourceExhausted,
      absl::StrCat("the build took longer than ",
                   is_servers ? "this server's limit of " : "max_time, ",
                   absl::FormatDuration(limit), ": ask for a coarser mesh, ",
                   is_servers ? "or build it elsewhere" : "or give it more time"),
      error);
}

}  // namespace dynmesh::server
