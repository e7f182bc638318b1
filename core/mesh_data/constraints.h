// Subsegments and subfacets as one kind of column: rows of K ids and an owner. Code for columns
// treats both alike by this header. Pure functions, thread-safe.
//
// A row includes its owner: the same ids under another owner are another constraint.
#ifndef DYNMESH_CORE_MESH_DATA_CONSTRAINTS_H_
#define DYNMESH_CORE_MESH_DATA_CONSTRAINTS_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "dynmesh/mesh.h"

namespace dynmesh::mesh_data {

// The number of ids of a row.
template <class Columns>
inline constexpr std::size_t kCorners = 0;
template <>
inline constexpr std::size_t kCorners<SubsegmentColumns> = 2;
template <>
inline constexpr std::size_t kCorners<SubfacetColumns> = 3;

// A row: its ids, ascending, and its owner.
template <std::size_t kIds>
using ConstraintRow = std::array<std::uint64_t, kIds + 1>;
template <class Columns>
using ConstraintKey = ConstraintRow<kCorners<Columns>>;

// The name for messages.
template <class Columns>
inline constexpr const char* kConstraintName =
    std::is_same_v<Columns, SubsegmentColumns> ? "subsegment" : "subfacet";

inline std::vector<VertexId>& IdsOf(SubsegmentColumns& s) { return s.ends; }
inline const std::vector<VertexId>& IdsOf(const SubsegmentColumns& s) { return s.ends; }
inline std::vector<VertexId>& IdsOf(SubfacetColumns& s) { return s.corners; }
inline const std::vector<VertexId>& IdsOf(const SubfacetColumns& s) { return s.corners; }

// Row i, whatever the order of its ids.
template <class Columns>
ConstraintKey<Columns> KeyOf(const Columns& columns, std::size_t row) {
  constexpr std::size_t kIds = kCorners<Columns>;
  ConstraintKey<Columns> key;
  std::copy_n(&IdsOf(columns)[kIds * row], kIds, key.begin());
  key[kIds] = columns.owners[row];
  std::sort(key.begin(), key.end() - 1);
  return key;
}

template <class Columns>
void Append(Columns& to, const ConstraintKey<Columns>& key) {
  IdsOf(to).insert(IdsOf(to).end(), key.begin(), key.end() - 1);
  to.owners.push_back(key.back());
}

inline MeshHash HashOf(const ConstraintRow<2>& key) {
  return HashSubsegment(key[0], key[1], key[2]);
}
inline MeshHash HashOf(const ConstraintRow<3>& key) {
  return HashSubfacet({key[0], key[1], key[2]}, key[3]);
}

// Do the columns agree in length?
template <class Columns>
bool Agree(const Columns& columns) {
  return IdsOf(columns).size() == kCorners<Columns> * columns.owners.size();
}

// Memory of the columns.
template <class Columns>
std::size_t ByteSize(const Columns& columns) {
  return columns.size() * sizeof(ConstraintKey<Columns>);
}

}  // namespace dynmesh::mesh_data

#endif  // DYNMESH_CORE_MESH_DATA_CONSTRAINTS_H_
