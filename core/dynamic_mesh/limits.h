// What a run may not exceed, asked while it goes on and at its end.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_LIMITS_H_
#define DYNMESH_CORE_DYNAMIC_MESH_LIMITS_H_

#include <string>

#include "absl/status/status.h"
#include "dynmesh/error.h"
#include "dynmesh/options.h"

namespace dynmesh {

template <class Refinement>
bool IsOverLimits(const Refinement& refinement, const Limits& limits) {
  return refinement.vertex_count() > limits.max_vertices || refinement.hit_depth_limit();
}

// The error of a run that is over a limit; OK of another.
template <class Refinement>
absl::Status LimitsStatus(const Refinement& refinement, const Limits& limits) {
  if (refinement.hit_depth_limit()) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     "a segment would have to be halved more often than max_depth = " +
                         std::to_string(limits.max_depth) +
                         " allows; move the features that lie so close to it apart",
                     {reason::kDepthLimit, {}, {}});
  }
  if (refinement.vertex_count() > limits.max_vertices) {
    return MakeError(
        absl::StatusCode::kResourceExhausted,
        "the mesh would have more than max_vertices = " + std::to_string(limits.max_vertices) +
            " vertices; add fewer features, or create it with a higher limit or a larger max_edge",
        {reason::kVertexLimit, {}, {}});
  }
  return absl::OkStatus();
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_LIMITS_H_
