// The limit of vertices of a mesh that a command makes from scratch.
#ifndef DYNMESH_CLIENT_CLI_VERTEX_LIMIT_H_
#define DYNMESH_CLIENT_CLI_VERTEX_LIMIT_H_

#include <cstdint>
#include <string>
#include <vector>

#include "client/preparation/default_limit.h"
#include "core/base/memory_budget.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::cli {

using preparation::DefaultMostVertices;
using preparation::kFewestVertices;
using preparation::kVerticesForFeature;

struct VertexLimit {
  std::uint64_t most = 0;
  std::string reason;  // why it is neither the user's nor the library's; else empty
};
// That of `options` if the user has given it, else the default; no more than certainly fit into the
// memory.
VertexLimit VertexLimitOf(const std::vector<Feature>& features, const MeshOptions& options,
                          bool is_given, const MemoryBudget& memory);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_VERTEX_LIMIT_H_
