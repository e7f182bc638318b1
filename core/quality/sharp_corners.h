// The facets of a 3D mesh at its vertices, and the corners where a segment or an edge rises over a
// facet at a small angle. Near such a corner vertices of several features are at one distance from
// it, as near to each other as the angle makes them. Found from the mesh alone. Immutable,
// thread-safe.
#ifndef DYNMESH_CORE_QUALITY_SHARP_CORNERS_H_
#define DYNMESH_CORE_QUALITY_SHARP_CORNERS_H_

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/base/id_table.h"
#include "dynmesh/mesh.h"

namespace dynmesh::quality {

class SharpCorners {
 public:
  using Row = std::size_t;

  SharpCorners() = default;
  // `row_of`: as for SeditiousEdges. `ways`: pairs of a corner and a vertex next to it on a segment
  // or an edge. O(size + sum of squares of the features at a corner).
  SharpCorners(const Mesh& mesh, const IdTable& row_of,
               const std::vector<std::pair<Row, Row>>& ways);

  bool empty() const { return sharp_.empty(); }
  bool Has(Row corner) const { return sharp_.contains(corner); }
  // The sharp corners of the facets with that vertex.
  const std::vector<Row>& Of(Row vertex) const;

 private:
  absl::flat_hash_set<Row> sharp_;
  absl::flat_hash_map<Row, std::vector<Row>> corners_;
};

}  // namespace dynmesh::quality

#endif  // DYNMESH_CORE_QUALITY_SHARP_CORNERS_H_
