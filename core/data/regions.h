// Columns of regions, which stand beside columns of simplices, and the sets that they
// name. Pure functions, thread-safe.
//
// In canonical form a column has an entry that is not 0 or is empty, and there are those
// sets, by ascending id, that some column names.
#ifndef DYNMESH_CORE_DATA_REGIONS_H_
#define DYNMESH_CORE_DATA_REGIONS_H_

#include <cstddef>
#include <initializer_list>
#include <vector>

#include "dynmesh/mesh.h"

namespace dynmesh::data {

// Clears a column that says nothing. O(the zeros at its beginning).
void DropIfIdle(RegionColumn& regions);

// Orders `sets` and keeps of them each once what the columns name. O(rows) if there are any.
void KeepNamed(std::vector<RegionSet>& sets, std::initializer_list<const RegionColumn*> columns);

// Appends the sets of `from` to those of `to`; KeepNamed puts them in order.
void AppendSets(std::vector<RegionSet>& to, const std::vector<RegionSet>& from);

// Two polygons at least, ascending, and the id is theirs.
bool IsRegionSet(const RegionSet& set);

// Each is one, and their ids ascend.
bool AreRegionSets(const std::vector<RegionSet>& sets);

// Memory of the sets.
std::size_t ByteSize(const std::vector<RegionSet>& sets);

}  // namespace dynmesh::data

#endif  // DYNMESH_CORE_DATA_REGIONS_H_
