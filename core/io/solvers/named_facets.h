// The facets of a mesh on features and on its border, by name: what solvers take boundary
// conditions and loads by. Facets are edges of triangles in 2D, triangles of tetrahedra in 3D.
#ifndef DYNMESH_CORE_IO_SOLVERS_NAMED_FACETS_H_
#define DYNMESH_CORE_IO_SOLVERS_NAMED_FACETS_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/io/meshes/indexed_mesh.h"
#include "core/io/solvers/edge_chains.h"

namespace dynmesh::io {

// A side of a simplex. Between two simplices it is that of the one with the lesser number of its
// region, of one region that of the lesser row.
struct NamedFacet {
  std::uint32_t simplex = 0;
  int opposite = 0;        // the corner of the simplex that is not on it
  bool is_border = false;  // there is no simplex on the other side
};

struct FacetSet {
  std::string name;                // unique among the sets and regions of a file, not empty
  std::vector<NamedFacet> facets;  // by simplex, then corner
};

struct RegionSet {
  std::string name;
  std::vector<std::uint32_t> simplices;  // ascending
};

// Sets and regions by their numbers as groups of a .msh (msh_groups.h), with those names. Facets of
// the border that lie on no feature, or on one without a marker where markers replace ids, come
// last as "border". No set is empty.
struct NamedParts {
  std::vector<FacetSet> facets;
  std::vector<RegionSet> regions;
};

// INVALID_ARGUMENT if there are too many rows for 32 bits. O(n lg n) expected.
absl::StatusOr<NamedParts> NamePartsOf(const IndexedMesh& mesh);

// The corners of a facet: in 2D two, with the triangle on the left; in 3D three, counter-clockwise
// as seen from outside of the tetrahedron. The others are not set.
std::array<std::uint32_t, 3> CornersOf(const IndexedMesh& mesh, const NamedFacet& facet);

// The edges of a set, with their triangles on the left. REQUIRES: dimension 2.
std::vector<DirectedEdge> EdgesOf(const IndexedMesh& mesh, const FacetSet& set);

// A name for formats whose names are words of letters, digits and _ that begin with a letter, of at
// most `most` characters. Other characters become _.
std::string WordOf(const std::string& name, std::size_t most);
// The words of `names`, in their order: those that are equal, but for their case, which programs
// ignore, get numbers behind them.
std::vector<std::string> WordsOf(const std::vector<std::string>& names, std::size_t most);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SOLVERS_NAMED_FACETS_H_
