// The edges of a mesh that may be short because of a small angle of the input: the ends lie on two
// segments that meet at less than 60 degrees, or on facets of a corner with small angles, at the
// same distance from the common point. In 3D distances count as equal up to 2^-17 of them: the
// vertices of shells are beside these on purpose. Found from the mesh alone, independently of the
// mesher.
// Immutable, thread-safe.
#ifndef DYNMESH_CLIENT_VERIFY_EXCUSES_H_
#define DYNMESH_CLIENT_VERIFY_EXCUSES_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <set>
#include <tuple>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "client/verify/vectors.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::cli {

class Excuses {
 public:
  // `ulp`: the spacing of doubles at the largest coordinate. The mesh must outlive the object.
  Excuses(const io::IndexedMesh& mesh, double ulp);

  // Is the edge between two vertices excused? O(ends of a segment + corners of a facet).
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

  // 3D. Are two opposite edges excused, and is a corner inside a facet? Such a tetrahedron may be
  // flat: its corners are those of a trapezoid across a small angle between facets.
  bool AreOpposite(const io::IndexedMesh::Tetrahedron& t) const;

  Real Distance(std::uint32_t p, std::uint32_t q) const;

  // The length of the simplex's shortest edge that counts; infinite if none does. In 2D these are
  // the edges that are not excused. In 3D corners that excused edges join, one after the other,
  // stand for one, and of the edges between two such sets the longest counts.
  template <class Simplex>
  Real ShortestOf(const Simplex& s) const {
    constexpr std::size_t n = std::tuple_size_v<Simplex>;
    std::array<std::array<bool, n>, n> joined = {};
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) joined[i][j] = i == j || Excused(s[i], s[j]);
    }
    for (std::size_t k = 0; n == 4 && k < n; ++k) {
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) joined[i][j] |= joined[i][k] && joined[k][j];
      }
    }
    Real shortest = std::numeric_limits<Real>::infinity();
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (joined[i][j]) continue;
        Real longest = Distance(s[i], s[j]);
        for (std::size_t p = 0; n == 4 && p < n; ++p) {
          for (std::size_t q = 0; q < n; ++q) {
            if (joined[i][p] && joined[j][q]) longest = std::max(longest, Distance(s[p], s[q]));
          }
        }
        shortest = std::min(shortest, longest);
      }
    }
    return shortest;
  }

 private:
  bool IsOfSegments(std::uint32_t p, std::uint32_t q) const;
  bool AreEqual(Real to_p, Real to_q) const;
  bool IsOfFacets(std::uint32_t p, std::uint32_t q) const;
  void FindNarrowCorners();
  bool AreNarrow(const io::IndexedMesh::Face& f, const io::IndexedMesh::Face& g,
                 std::uint32_t corner) const;
  bool IsNarrow(std::uint32_t way, const io::IndexedMesh::Face& face, std::uint32_t corner) const;

  const io::IndexedMesh& mesh_;
  const Real tolerance_;
  // By vertex: a vertex that stands for the segment with it in the inside.
  std::vector<std::uint32_t> segment_;
  absl::flat_hash_map<std::uint32_t, std::vector<std::uint32_t>> ends_;  // of a segment
  // 3D, by vertex: the corners, with facets at small angles, of the polygons and segments that the
  // vertex lies on.
  std::vector<std::set<std::uint32_t>> narrow_;
};

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_VERIFY_EXCUSES_H_
