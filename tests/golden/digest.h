// Hashes of whole meshes and diffs, column by column: every value, its order, and where columns
// end.
#ifndef DYNMESH_TESTS_GOLDEN_DIGEST_H_
#define DYNMESH_TESTS_GOLDEN_DIGEST_H_

#include <bit>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "core/base/mix.h"
#include "dynmesh/mesh.h"

namespace dynmesh::test {

class Digest {
 public:
  std::uint64_t value() const { return value_; }
  friend bool operator==(const Digest&, const Digest&) = default;

  void Add(std::uint64_t word) { value_ = Mix(value_ ^ word); }
  void Add(double x) { Add(std::bit_cast<std::uint64_t>(x)); }
  void Add(const MeshHash& hash) { Add(hash.hi), Add(hash.lo); }
  void Add(const RegionSet& set) { Add(set.id), Add(set.polygons); }
  void Add(const VertexColumns& columns) {
    Add(columns.ids), Add(columns.coordinates);
    Add(columns.containing_dimensions), Add(columns.owners);
  }
  void Add(const SubsegmentColumns& columns) { Add(columns.ends), Add(columns.owners); }
  void Add(const SubfacetColumns& columns) { Add(columns.corners), Add(columns.owners); }
  template <class T>
  void Add(const std::vector<T>& column) {
    Add(std::uint64_t{column.size()});
    for (const T& x : column) {
      if constexpr (std::is_integral_v<T>) {
        Add(std::uint64_t{x});
      } else {
        Add(x);
      }
    }
  }

  // In canonical order.
  void Add(Mesh mesh) {
    Canonicalize(mesh);
    Add(mesh.revision), Add(mesh.vertices), Add(mesh.simplices), Add(mesh.regions);
    Add(mesh.region_sets), Add(mesh.subsegments), Add(mesh.subfacets), Add(mesh.hash);
  }
  // In canonical order; not the work.
  void Add(MeshDiff diff) {
    Canonicalize(diff);
    Add(diff.from_revision), Add(diff.to_revision), Add(diff.removed_vertices);
    Add(diff.removed_simplices), Add(diff.removed_regions), Add(diff.removed_subsegments);
    Add(diff.removed_subfacets), Add(diff.added_vertices), Add(diff.added_simplices);
    Add(diff.added_regions), Add(diff.region_sets), Add(diff.added_subsegments);
    Add(diff.added_subfacets), Add(diff.hash);
  }

 private:
  std::uint64_t value_ = 0;
};

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_GOLDEN_DIGEST_H_
