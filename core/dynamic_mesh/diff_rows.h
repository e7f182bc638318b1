// Rows of a mesh and of a diff by public ids: sorting, netting, hashing, appending to columns. Pure
// functions and plain data.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_DIFF_ROWS_H_
#define DYNMESH_CORE_DYNAMIC_MESH_DIFF_ROWS_H_

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dynmesh/mesh.h"

namespace dynmesh {

template <int D>
struct VertexRow {
  VertexId id;
  std::array<double, D> coordinates;
  int dimension;
  FeatureId owner;
  friend auto operator<=>(const VertexRow&, const VertexRow&) = default;
};
// A subsegment or subfacet.
template <int N>
struct ConstraintRow {
  std::array<VertexId, N> corners;  // ascending
  FeatureId owner;
  friend auto operator<=>(const ConstraintRow&, const ConstraintRow&) = default;
};
template <int D>
struct SimplexRow {
  std::array<VertexId, D + 1> ids;  // canonical order
  RegionId region;
  friend auto operator<=>(const SimplexRow&, const SimplexRow&) = default;
};

template <std::size_t N>
ConstraintRow<static_cast<int>(N)> ConstraintRowOf(std::array<VertexId, N> corners,
                                                   FeatureId owner) {
  std::sort(corners.begin(), corners.end());
  return {corners, owner};
}

// Removed and added rows.
template <class Row>
struct Rows {
  std::vector<Row> gone, come;
  void Clear() { gone.clear(), come.clear(); }
  // Removes rows that are in both lists, and sorts the rest.
  void Net() {
    std::sort(gone.begin(), gone.end());
    std::sort(come.begin(), come.end());
    auto i = gone.begin(), j = come.begin(), only_gone = gone.begin(), only_come = come.begin();
    while (i != gone.end() && j != come.end()) {
      if (*i < *j) {
        *only_gone++ = *i++;
      } else if (*j < *i) {
        *only_come++ = *j++;
      } else {
        ++i, ++j;
      }
    }
    gone.erase(std::copy(i, gone.end(), only_gone), gone.end());
    come.erase(std::copy(j, come.end(), only_come), come.end());
  }
};

template <int D>
MeshHash HashOf(const VertexRow<D>& row) {
  return HashVertex(row.coordinates.data(), D, row.dimension, row.owner);
}
template <int D>
MeshHash HashOf(const SimplexRow<D>& row) {
  return HashSimplex(row.ids.data(), D + 1, row.region);
}
inline MeshHash HashOf(const ConstraintRow<2>& row) {
  return HashSubsegment(row.corners[0], row.corners[1], row.owner);
}
inline MeshHash HashOf(const ConstraintRow<3>& row) {
  const VertexId corners[3] = {row.corners[0], row.corners[1], row.corners[2]};
  return HashSubfacet(corners, row.owner);
}

// Nets the rows, and changes the hash by them.
template <class Row>
void NetAndHash(Rows<Row>* rows, MeshHash* hash) {
  rows->Net();
  for (const Row& row : rows->gone) *hash -= HashOf(row);
  for (const Row& row : rows->come) *hash += HashOf(row);
}

inline void Reserve(VertexColumns& columns, int dimension, std::size_t rows) {
  columns.ids.reserve(rows);
  columns.coordinates.reserve(static_cast<std::size_t>(dimension) * rows);
  columns.containing_dimensions.reserve(rows);
  columns.owners.reserve(rows);
}

template <int D>
void Append(VertexColumns& to, const VertexRow<D>& row) {
  to.ids.push_back(row.id);
  for (const double c : row.coordinates) to.coordinates.push_back(c);
  to.containing_dimensions.push_back(static_cast<std::uint8_t>(row.dimension));
  to.owners.push_back(row.owner);
}
inline void Append(SubsegmentColumns& to, const ConstraintRow<2>& row) {
  for (const VertexId end : row.corners) to.ends.push_back(end);
  to.owners.push_back(row.owner);
}
inline void Append(SubfacetColumns& to, const ConstraintRow<3>& row) {
  for (const VertexId corner : row.corners) to.corners.push_back(corner);
  to.owners.push_back(row.owner);
}

// Appends the rows of constraints to the columns of a diff.
template <int N, class Columns>
void Report(const Rows<ConstraintRow<N>>& rows, Columns* removed, Columns* added) {
  for (const ConstraintRow<N>& row : rows.gone) Append(*removed, row);
  for (const ConstraintRow<N>& row : rows.come) Append(*added, row);
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_DIFF_ROWS_H_
