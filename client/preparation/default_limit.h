// How many vertices a mesh may have by default when a command makes it from scratch.
#ifndef DYNMESH_CLIENT_PREPARATION_DEFAULT_LIMIT_H_
#define DYNMESH_CLIENT_PREPARATION_DEFAULT_LIMIT_H_

#include <cstdint>
#include <vector>

#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::preparation {

// kFewestVertices, or kVerticesForFeature for each feature if that is more. Target lengths say how
// fine a mesh is to be: with them, the limit of `options`, which is never exceeded. O(n).
inline constexpr std::uint64_t kFewestVertices = 2'000'000, kVerticesForFeature = 500;
std::uint64_t DefaultMostVertices(const std::vector<Feature>& features, const MeshOptions& options);

}  // namespace dynmesh::preparation

#endif  // DYNMESH_CLIENT_PREPARATION_DEFAULT_LIMIT_H_
