// The canonical order of rows: what makes two equal meshes equal byte by byte.
// O(n lg n) in the number of rows.
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "dynmesh/mesh.h"

namespace dynmesh {
namespace {

// The order of n rows under `less`, as indices.
template <class Less>
std::vector<std::size_t> SortedRows(std::size_t n, Less less) {
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), less);
  return order;
}

// Rows of `width` entries, rearranged so that row i is the former row order[i].
template <class T>
void Permute(const std::vector<std::size_t>& order, std::size_t width, std::vector<T>& column) {
  std::vector<T> sorted;
  sorted.reserve(column.size());
  for (const std::size_t row : order) {
    const auto begin = column.begin() + static_cast<std::ptrdiff_t>(row * width);
    sorted.insert(sorted.end(), begin, begin + static_cast<std::ptrdiff_t>(width));
  }
  column = std::move(sorted);
}

void SortVertices(int dimension, VertexColumns& v) {
  const auto order =
      SortedRows(v.size(), [&](std::size_t i, std::size_t j) { return v.ids[i] < v.ids[j]; });
  Permute(order, 1, v.ids);
  Permute(order, static_cast<std::size_t>(dimension), v.coordinates);
  Permute(order, 1, v.containing_dimensions);
  Permute(order, 1, v.owners);
}

void SortSimplices(int dimension, SimplexColumn& simplices) {
  const std::size_t width = static_cast<std::size_t>(dimension) + 1;
  const auto order = SortedRows(simplices.size() / width, [&](std::size_t i, std::size_t j) {
    const VertexId* a = &simplices[i * width];
    const VertexId* b = &simplices[j * width];
    return std::lexicographical_compare(a, a + width, b, b + width);
  });
  Permute(order, width, simplices);
}

void SortSubsegments(SubsegmentColumns& s) {
  const auto order = SortedRows(s.size(), [&](std::size_t i, std::size_t j) {
    if (s.ends[2 * i] != s.ends[2 * j]) return s.ends[2 * i] < s.ends[2 * j];
    if (s.ends[2 * i + 1] != s.ends[2 * j + 1]) return s.ends[2 * i + 1] < s.ends[2 * j + 1];
    return s.owners[i] < s.owners[j];
  });
  Permute(order, 2, s.ends);
  Permute(order, 1, s.owners);
}

}  // namespace

void Canonicalize(Mesh& mesh) {
  SortVertices(mesh.dimension, mesh.vertices);
  SortSimplices(mesh.dimension, mesh.simplices);
  SortSubsegments(mesh.subsegments);
}

void Canonicalize(MeshDiff& diff) {
  std::sort(diff.removed_vertices.begin(), diff.removed_vertices.end());
  SortSimplices(diff.dimension, diff.removed_simplices);
  SortSubsegments(diff.removed_subsegments);
  SortVertices(diff.dimension, diff.added_vertices);
  SortSimplices(diff.dimension, diff.added_simplices);
  SortSubsegments(diff.added_subsegments);
}

}  // namespace dynmesh
