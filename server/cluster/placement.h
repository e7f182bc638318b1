// Which of several servers is to serve a mesh: rendezvous hashing. Each server computes the same
// choice, without a message. When a server comes or goes, only the meshes that it is or was chosen
// for change. The choice is a wish: the journal's epoch decides which server writes. Pure
// functions, thread-safe.
#ifndef DYNMESH_SERVER_CLUSTER_PLACEMENT_H_
#define DYNMESH_SERVER_CLUSTER_PLACEMENT_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace dynmesh::server {

// The weight of the mesh on the node: a fixed function of the bytes of both, the same in each
// build and on each machine, as versions of the server run side by side.
std::uint64_t PlacementWeight(absl::string_view node, absl::string_view mesh);

// The index in `nodes` of the node with the largest weight; of equal weights the smaller name has
// it. Does not depend on the order of `nodes`. Nothing without nodes. O(bytes of all names).
std::optional<std::size_t> ChooseNode(const std::vector<std::string>& nodes,
                                      absl::string_view mesh);

// Those to which the mesh goes next: the `count` nodes, or fewer, with the largest weights among
// `nodes` without `owner`, the largest first. O(bytes of all names + nodes log count).
std::vector<std::string> NextNodes(const std::vector<std::string>& nodes, absl::string_view owner,
                                   absl::string_view mesh, std::size_t count);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CLUSTER_PLACEMENT_H_
