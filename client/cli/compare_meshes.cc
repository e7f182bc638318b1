#include "client/cli/compare_meshes.h"

#include <algorithm>
#include <span>

#include "core/mesh_data/diff_meshes.h"

namespace dynmesh::cli {
namespace {

MeshComparison::Part Count(std::uint64_t in_a, std::uint64_t only_a, std::uint64_t only_b) {
  return {in_a - only_a, only_a, only_b};
}

// Simplices in both columns, which are sorted: they kept their vertices.
std::uint64_t CountInBoth(const SimplexColumn& a, const SimplexColumn& b, std::size_t width) {
  const auto row = [width](const SimplexColumn& column, std::size_t i) {
    return std::span(column).subspan(i, width);
  };
  const auto less = [](std::span<const VertexId> x, std::span<const VertexId> y) {
    return std::lexicographical_compare(x.begin(), x.end(), y.begin(), y.end());
  };
  std::uint64_t count = 0;
  std::size_t k = 0;
  for (std::size_t i = 0; i < a.size(); i += width) {
    while (k < b.size() && less(row(b, k), row(a, i))) k += width;
    if (k < b.size() && !less(row(a, i), row(b, k))) ++count;
  }
  return count;
}

}  // namespace

bool MeshComparison::Same() const {
  const auto same = [](const Part& part) { return part.only_a == 0 && part.only_b == 0; };
  return same(vertices) && same(simplices) && same(subsegments) && same(subfacets) &&
         remarked_vertices == 0 && relabelled_simplices == 0;
}

MeshComparison CompareMeshes(const Mesh& a, const Mesh& b) {
  MeshDiff diff = mesh_data::DiffMeshes(a, b);
  Canonicalize(diff);
  MeshComparison result;
  // A vertex in both lists kept its position. Both are sorted by id.
  std::size_t next = 0;
  for (const VertexId id : diff.removed_vertices) {
    while (next < diff.added_vertices.size() && diff.added_vertices.ids[next] < id) ++next;
    if (next < diff.added_vertices.size() && diff.added_vertices.ids[next] == id) {
      ++result.remarked_vertices;
    }
  }
  result.vertices =
      Count(a.vertices.size(), diff.removed_vertices.size() - result.remarked_vertices,
            diff.added_vertices.size() - result.remarked_vertices);
  result.relabelled_simplices = CountInBoth(diff.removed_simplices, diff.added_simplices,
                                            static_cast<std::size_t>(a.dimension) + 1);
  result.simplices =
      Count(a.simplex_count(), diff.removed_simplex_count() - result.relabelled_simplices,
            diff.added_simplex_count() - result.relabelled_simplices);
  result.subsegments =
      Count(a.subsegments.size(), diff.removed_subsegments.size(), diff.added_subsegments.size());
  result.subfacets =
      Count(a.subfacets.size(), diff.removed_subfacets.size(), diff.added_subfacets.size());
  result.hash_a = a.hash;
  result.hash_b = b.hash;
  return result;
}

}  // namespace dynmesh::cli
