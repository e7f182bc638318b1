// The leaves of a quadtree or octree, as files have them.
#ifndef DYNMESH_CORE_IO_QUADTREES_LEAF_LIST_H_
#define DYNMESH_CORE_IO_QUADTREES_LEAF_LIST_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"
#include "dynmesh/quadtree.h"

namespace dynmesh::io {

struct LeafList {
  struct Leaf {
    QuadtreeCell cell;
    std::array<double, 3> centre = {0, 0, 0};
    VertexId id = 0;  // 0 if not known
  };
  int dimension = 2;
  std::vector<Leaf> leaves;
};

// The leaves of `mesh`, of kind kQuadtree, by their cells. DATA_LOSS if a vertex is no centre.
absl::StatusOr<LeafList> LeavesOf(const Mesh& mesh, const MeshOptions& options);

// Comma-separated values: a line `x,y,side,level` (`x,y,z,side,level`), then one for each leaf,
// with its centre. Numbers read back to the bit. UNAVAILABLE, naming the path, on an error.
absl::Status WriteLeafCsv(const LeafList& list, const std::string& path);
// Reads such a file: centres, sides and levels; `at` and `box` remain as they are by default.
// INVALID_ARGUMENT as `file:line: ...`.
absl::StatusOr<LeafList> ReadLeafCsv(const std::string& path);

// A VTK file of quadrangles (hexahedra) with the cell data level, side and id. Common corners are
// one point. O(leaves).
absl::Status WriteLeafVtu(const LeafList& list, const std::string& path);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_QUADTREES_LEAF_LIST_H_
