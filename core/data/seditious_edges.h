// Which edges of a mesh are as short as a small input angle makes them: they join two
// vertices that were put on segments with a common end, a small angle apart, at the same
// distance from it. Found from the mesh alone. Thread-safe once made.
#ifndef DYNMESH_CORE_DATA_SEDITIOUS_EDGES_H_
#define DYNMESH_CORE_DATA_SEDITIOUS_EDGES_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "dynmesh/mesh.h"

namespace dynmesh::data {

class SeditiousEdges {
 public:
  // `row_of`: the rows of the mesh's vertices, by id. `mesh` (of dimension 2) must outlive
  // the object. O(size).
  SeditiousEdges(const Mesh& mesh, const absl::flat_hash_map<VertexId, std::size_t>& row_of);

  // Is the edge between the vertices in these rows one? O(1).
  bool Has(std::size_t p, std::size_t q) const;

 private:
  const Mesh& mesh_;
  double tolerance_;                                            // of equal distances
  absl::flat_hash_map<std::size_t, std::uint32_t> segment_of_;  // by row of a vertex inside it
  std::vector<std::array<std::size_t, 2>> ends_;                // rows of both ends of a segment
};

}  // namespace dynmesh::data

#endif  // DYNMESH_CORE_DATA_SEDITIOUS_EDGES_H_
