// What tests and benchmarks choose of a LiveMesh. It changes no bit of any result.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_TUNING_H_
#define DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_TUNING_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/dynamic_mesh/vertex_hash.h"
#include "core/sac/program.h"

namespace dynmesh {

// Thresholds above which a batch is rebuilt, as shares of what is present.
struct RebuildThresholds {
  std::size_t at_least = 64;     // changed features; fewer are propagated
  double probe_features = 0.01;  // from this share on, count stale operations first
  double features = 0.5;         // changed, of the present ones or of a fourth of the vertices
  double stale = 0.1;            // of the operations
  double carried = 0.3;          // vertices that sizing features need
  // A running propagation is stopped when it has executed more operations than allowed, not
  // counting those by which the trace has grown. Allowed are `work` of all operations, or
  // `work_of_stale` times those stale at the beginning but at most `most_work` of all.
  double work = 0.12, work_of_stale = 3, most_work = 0.25;
  std::uint64_t at_least_work = 1'000;  // operations
  // So many subscribers looked at count as an operation, in 2D and in 3D. Measured: a look takes
  // about 30 ns; an operation that runs again 8 us in 2D, 40 to 90 us in 3D.
  std::array<std::uint64_t, 2> looks = {256, 2048};
};

struct LiveMeshTuning {
  RebuildThresholds rebuild;
  // From scratch: read neighbourhoods from the growing triangulation.
  bool global_neighbourhoods = true;
  VertexHash vertex_hash = &VertexIdAt;
  // Smaller limits are for tests.
  sac::EngineLimits engine_limits = {};
  std::size_t most_tetrahedra = 0;  // 0: no limit but the indices
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_TUNING_H_
