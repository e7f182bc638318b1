// Columns of regions, parallel to columns of simplices, and the sets that they name. Pure
// functions, thread-safe.
//
// Canonical form: a column is empty or has a nonzero entry; the sets are those that some column
// names, by ascending id.
#ifndef DYNMESH_CORE_MESH_DATA_REGIONS_H_
#define DYNMESH_CORE_MESH_DATA_REGIONS_H_

#include <cstddef>
#include <initializer_list>
#include <vector>

#include "dynmesh/mesh.h"

namespace dynmesh::mesh_data {

// Clears a column of zeros. O(leading zeros).
void DropIfIdle(RegionColumn& regions);

// Sorts `sets` and keeps each that the columns name once. O(rows) if there are sets.
void KeepNamed(std::vector<RegionSet>& sets, std::initializer_list<const RegionColumn*> columns);

// Appends the sets of `from` to those of `to`; KeepNamed puts them in order.
void AppendSets(std::vector<RegionSet>& to, const std::vector<RegionSet>& from);

// At least two polygons, ascending, and the id is that of these.
bool IsRegionSet(const RegionSet& set);

// All are valid, and their ids ascend.
bool AreRegionSets(const std::vector<RegionSet>& sets);

// Memory of the sets.
std::size_t ByteSize(const std::vector<RegionSet>& sets);

}  // namespace dynmesh::mesh_data

#endif  // DYNMESH_CORE_MESH_DATA_REGIONS_H_
