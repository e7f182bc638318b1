// The canonical order of rows: what makes two equal meshes equal byte by byte.
// O(n lg n) in the number of rows.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "dynmesh/mesh.h"

namespace dynmesh {
namespace {

// Rows of `width` entries, rearranged so that row i is the former row order[i].
template <class T>
void Permute(const std::vector<std::uint32_t>& order, std::size_t width, std::vector<T>& column) {
  std::vector<T> sorted;
  sorted.reserve(column.size());
  for (const std::size_t row : order) {
    const auto begin = column.begin() + static_cast<std::ptrdiff_t>(row * width);
    sorted.insert(sorted.end(), begin, begin + static_cast<std::ptrdiff_t>(width));
  }
  column = std::move(sorted);
}

void SortVertices(int dimension, VertexColumns& v) {
  std::vector<std::uint32_t> order(v.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t i, std::uint32_t j) { return v.ids[i] < v.ids[j]; });
  Permute(order, 1, v.ids);
  Permute(order, static_cast<std::size_t>(dimension), v.coordinates);
  Permute(order, 1, v.containing_dimensions);
  Permute(order, 1, v.owners);
}

// Whole rows are sorted, not indices: no cache miss per comparison.
template <std::size_t kWidth>
void SortRows(SimplexColumn& simplices) {
  std::vector<std::array<VertexId, kWidth>> rows(simplices.size() / kWidth);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::copy_n(simplices.data() + i * kWidth, kWidth, rows[i].begin());
  }
  std::sort(rows.begin(), rows.end());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::copy_n(rows[i].begin(), kWidth, simplices.data() + i * kWidth);
  }
}

void SortSimplices(int dimension, SimplexColumn& simplices) {
  dimension == 2 ? SortRows<3>(simplices) : SortRows<4>(simplices);
}

void SortSubsegments(SubsegmentColumns& s) {
  std::vector<std::array<std::uint64_t, 3>> rows(s.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i] = {s.ends[2 * i], s.ends[2 * i + 1], s.owners[i]};
  }
  std::sort(rows.begin(), rows.end());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    s.ends[2 * i] = rows[i][0];
    s.ends[2 * i + 1] = rows[i][1];
    s.owners[i] = rows[i][2];
  }
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
