// Edges that are short because of a small input angle: they join vertices on two segments, or on
// facets, with a common corner and a small angle, at the same distance from that corner. Found from
// the mesh alone.
// Thread-safe once constructed.
#ifndef DYNMESH_CORE_QUALITY_SEDITIOUS_EDGES_H_
#define DYNMESH_CORE_QUALITY_SEDITIOUS_EDGES_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/base/id_table.h"
#include "core/quality/sharp_corners.h"
#include "dynmesh/mesh.h"

namespace dynmesh::quality {

class SeditiousEdges {
 public:
  // `row_of`: the rows of the mesh's vertices, by id. `mesh` must outlive the object. O(size).
  SeditiousEdges(const Mesh& mesh, const IdTable& row_of);

  // Is the edge between the vertices in these rows such an edge? O(corners of their facets).
  bool Has(std::size_t p, std::size_t q) const;

 private:
  bool IsOfSegments(std::size_t p, std::size_t q) const;
  bool IsOfFacets(std::size_t p, std::size_t q) const;

  const Mesh& mesh_;
  double tolerance_;                                            // of equal distances
  absl::flat_hash_map<std::size_t, std::uint32_t> segment_of_;  // by row of a vertex inside it
  std::vector<std::array<std::size_t, 2>> ends_;                // rows of both ends of a segment
  SharpCorners corners_;
};

}  // namespace dynmesh::quality

#endif  // DYNMESH_CORE_QUALITY_SEDITIOUS_EDGES_H_
