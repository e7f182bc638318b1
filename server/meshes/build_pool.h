// Builds meshes that the server does not keep, each on a thread of low priority, so that builds do
// not delay the meshes' edits. The caller limits their number. Thread-safe.
#ifndef DYNMESH_SERVER_MESHES_BUILD_POOL_H_
#define DYNMESH_SERVER_MESHES_BUILD_POOL_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "dynmesh/dynamic_mesh.h"
#include "server/base/memory_guard.h"
#include "server/base/worker_pool.h"
#include "server/config/config.h"
#include "server/meshes/batch_progress.h"
#include "server/metrics/server_metrics.h"

namespace dynmesh::server {

// Makes the mesh of a build; dynmesh::BuildMesh except in tests.
using MeshBuilder = std::function<absl::StatusOr<Mesh>(std::span<const Feature>, const MeshOptions&,
                                                       const BuildOptions&)>;

struct BuildJob {
  std::vector<Feature> features;
  MeshOptions options;
  BuildEngine engine = BuildEngine::kDynamic;
  bool only_inside = false;
  absl::Duration max_time = absl::InfiniteDuration();
  std::string call_id;  // of its call, for the log
  // Once true, the build ends soon, with CANCELLED.
  std::shared_ptr<const std::atomic<bool>> stopped;
  // Called on the build's thread, as BuildOptions::progress.
  std::function<void(const BatchProgress&)> progress;
  // Called once, on the build's thread.
  std::function<void(absl::StatusOr<Mesh>)> done;
};

class BuildPool {
 public:
  // The guard outlives the pool.
  BuildPool(const ServerConfig& config, MeshBuilder builder, const MemoryGuard* memory,
            BuildMetrics* metrics);

  // False if there is no builder: then do not call Post.
  bool can_build() const { return builder_ != nullptr; }

  // Errors, to job.done: those of dynmesh::BuildMesh; RESOURCE_EXHAUSTED (TIME_LIMIT,
  // MEMORY_LIMIT).
  void Post(BuildJob job);

  // As WorkerPool::Stop.
  void Stop() { threads_.Stop(); }

 private:
  void Run(BuildJob& job) const;
  absl::StatusOr<Mesh> Build(const BuildJob& job) const;
  absl::Status TimeLimitError(absl::Duration limit) const;

  const MeshBuilder builder_;
  const std::uint64_t max_operations_;
  const absl::Duration max_time_;
  const MemoryGuard* const memory_;
  BuildMetrics* const metrics_;
  WorkerPool threads_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_BUILD_POOL_H_
