// Limits of a run, checked during it and at its end.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_LIMITS_H_
#define DYNMESH_CORE_DYNAMIC_MESH_LIMITS_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "core/dynamic_mesh/limit_terms.h"
#include "dynmesh/error.h"
#include "dynmesh/options.h"

namespace dynmesh {

template <class Refinement>
bool IsOverLimits(const Refinement& refinement, std::uint64_t most_vertices) {
  return (IsOn(LimitTerm::kVerticesEnd) && refinement.vertex_count() > most_vertices) ||
         (IsOn(LimitTerm::kDepthRefuses) && refinement.hit_depth_limit()) || refinement.is_full();
}

inline absl::Status VertexLimitError(const MeshOptions& options) {
  const std::string most = std::to_string(options.limits.max_vertices);
  return MakeError(absl::StatusCode::kResourceExhausted,
                   options.kind == MeshKind::kQuadtree
                       ? "the quadtree would have more than max_vertices = " + most +
                             " leaves; add fewer features, or create it with a higher limit"
                       : "the mesh would have more than max_vertices = " + most +
                             " vertices; add fewer features, or create it with a higher limit" +
                             (options.kind == MeshKind::kDelaunay ? " or a larger max_edge" : ""),
                   {reason::kVertexLimit, {}, {}});
}

// More than indices can distinguish (options.h, MostVertices).
inline absl::Status SizeLimitError() {
  return MakeError(absl::StatusCode::kResourceExhausted,
                   "the mesh would have more vertices, segments or simplices than can be told "
                   "apart; add fewer features, or create it with a larger max_edge or a lower "
                   "quality ratio",
                   {reason::kSizeLimit, {}, {}});
}

// The error of a run that exceeds a limit; else OK.
template <class Refinement>
absl::Status LimitsStatus(const Refinement& refinement, const MeshOptions& options) {
  const Limits& limits = options.limits;
  if (IsOn(LimitTerm::kDepthRefuses) && refinement.hit_depth_limit()) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     "a segment would have to be halved more often than max_depth = " +
                         std::to_string(limits.max_depth) +
                         " allows; move the features that lie so close to it apart",
                     {reason::kDepthLimit, {}, {}});
  }
  if (IsOn(LimitTerm::kVerticesEnd) && refinement.vertex_count() > limits.max_vertices) {
    return VertexLimitError(options);
  }
  if (refinement.is_full()) return SizeLimitError();
  if (const auto at = refinement.OverflowAt()) {
    std::string position;
    for (const double c : at->c) position += (position.empty() ? "(" : ", ") + std::to_string(c);
    return MakeError(absl::StatusCode::kResourceExhausted,
                     "near " + position +
                         ") a vertex would have more neighbours, or be in the way of more "
                         "segments, than an operation can keep; put points between them",
                     {reason::kSizeLimit, {}, {}});
  }
  return absl::OkStatus();
}

// The error of a mesh that is interrupted while it is made.
inline absl::Status GivenUpError() {
  return MakeError(absl::StatusCode::kCancelled, "the mesh was given up while it was made",
                   {reason::kCancelled, {}, {}});
}

// The error of a batch that needs more than max_operations.
inline absl::Status WorkLimitError(std::uint64_t max_operations) {
  return MakeError(absl::StatusCode::kResourceExhausted,
                   "the batch takes more than max_operations = " + std::to_string(max_operations) +
                       " operations; nothing has changed: send it in smaller batches, make less "
                       "of the mesh finer at once, or allow more operations",
                   {reason::kWorkLimit, {}, {}});
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_LIMITS_H_
