// The edges of a mesh that may be short because of a small angle of the input: the ends lie on two
// segments that meet at less than 60 degrees, at the same distance from the common point. Found
// from the mesh alone, independently of the mesher. Immutable, thread-safe.
#ifndef DYNMESH_CLIENT_VERIFY_EXCUSES_H_
#define DYNMESH_CLIENT_VERIFY_EXCUSES_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::cli {

class Excuses {
 public:
  using Real = long double;

  // `ulp`: the spacing of doubles at the largest coordinate. The mesh must outlive the object.
  Excuses(const io::IndexedMesh& mesh, double ulp);

  // Is the edge between two vertices excused? O(ends of a segment).
  bool Excused(std::uint32_t p, std::uint32_t q) const;

  // Is one of the simplex's edges excused?
  template <class Simplex>
  bool AnyOf(const Simplex& s) const {
    for (std::size_t i = 0; i < s.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (Excused(s[i], s[j])) return true;
      }
    }
    return false;
  }

  Real Distance(std::uint32_t p, std::uint32_t q) const;

  // The length of the simplex's shortest edge that is not excused; infinite if all are.
  template <class Simplex>
  Real ShortestOf(const Simplex& s) const {
    Real shortest = std::numeric_limits<Real>::infinity();
    for (std::size_t i = 0; i < s.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (!Excused(s[i], s[j])) shortest = std::min(shortest, Distance(s[i], s[j]));
      }
    }
    return shortest;
  }

 private:
  const io::IndexedMesh& mesh_;
  const Real tolerance_;
  // By vertex: a vertex that stands for the segment with it in the inside.
  std::vector<std::uint32_t> segment_;
  absl::flat_hash_map<std::uint32_t, std::vector<std::uint32_t>> ends_;  // of a segment
};

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_VERIFY_EXCUSES_H_
