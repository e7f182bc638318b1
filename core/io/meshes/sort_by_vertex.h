// Sorts rows by the number of a vertex first, as all rows of mesh files.
#ifndef DYNMESH_CORE_IO_MESHES_SORT_BY_VERTEX_H_
#define DYNMESH_CORE_IO_MESHES_SORT_BY_VERTEX_H_

#include <algorithm>
#include <cstddef>
#include <vector>

namespace dynmesh::io {

// The same result as std::sort with `less`, but in linear time if few rows begin with the same
// vertex. first(row), below `vertices`, must be the first key of `less`. Needs memory for a copy of
// the rows. Rows that are equal by `less` are in any order.
template <class Row, class First, class Less>
void SortByVertex(std::vector<Row>& rows, std::size_t vertices, First first, Less less) {
  std::vector<std::size_t> next(vertices + 1,
                                0);  // by vertex: the index of its first row, then past its last
  for (const Row& row : rows) ++next[first(row) + std::size_t{1}];
  for (std::size_t v = 1; v <= vertices; ++v) next[v] += next[v - 1];
  std::vector<Row> sorted(rows.size());
  for (const Row& row : rows) sorted[next[first(row)]++] = row;
  auto begin = sorted.begin();
  for (std::size_t v = 0; v < vertices; ++v) {
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(next[v]);
    std::sort(begin, end, less);
    begin = end;
  }
  rows.swap(sorted);
}

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_SORT_BY_VERTEX_H_
