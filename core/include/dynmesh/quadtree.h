// Size-conforming quadtrees, in 3D octrees: meshes of kind MeshKind::kQuadtree.
//
//   dynmesh::MeshOptions options;
//   options.kind = dynmesh::MeshKind::kQuadtree;
//   auto tree = dynmesh::DynamicMesh::Create(options);      // check tree.ok()
//   auto diff = (*tree)->Apply(batch);                      // check diff.ok()
//   const double* centre = diff->added_vertices.coordinates.data();
//   auto leaf = dynmesh::QuadtreeCellAt(options, centre);   // its level, side and box
//
// The root cell is a square (cube) around the user's box; a cell is a leaf or has four (eight)
// children. A mesh of this kind has one vertex for each leaf, at its centre, and nothing else:
// diffs, hashes, files and replicas work as for all meshes. A vertex's containing dimension is that
// of the mesh, its owner is kNoFeature, its id is VertexIdAt(centre) with salt 0.
// DynamicMesh::Locate returns the vertex of the leaf first, and zeros.
//
// Guarantees, for any features (Hudson, Dynamic Mesh Refinement, Thm 4.1.4). lfs(x), the local
// feature size, is the radius of the least ball about x that meets two features without a common
// point.
//   1. Leaves that touch differ in side by a factor of 2 at most.
//   2. side / 4 <= lfs(x) <= 4.5 sqrt(dimension) side, for x in a leaf with this side. (The upper
//      bound needs lfs(x) to be below the root's side.)
//   3. The leaves are a function of options and features. An edit changes O(m_f lg(L / s)) leaves
//      in as much time: m_f is the number of leaves that the feature meets, L the root's side, s
//      the least distance between features without a common point.
//
// Features are those of other meshes, but may meet at any angle. Sizing features are refused
// (BAD_SIZE).
#ifndef DYNMESH_QUADTREE_H_
#define DYNMESH_QUADTREE_H_

#include <array>
#include <cstdint>
#include <optional>

#include "dynmesh/options.h"

namespace dynmesh {

// A cell of the tree. `at`: its number along each axis among the 2^level cells of its size.
struct QuadtreeCell {
  int level = 0;                      // 0: the root, DomainBox(options)
  std::array<std::uint64_t, 3> at{};  // entries past the dimension are 0
  double side = 0;                    // of the square or cube
  Box box;                            // exact
  friend bool operator==(const QuadtreeCell&, const QuadtreeCell&) = default;
};

// The cell with this centre, `options.dimension` coordinates, in the tree of `options`; nothing if
// there is none. Exact, O(1). REQUIRES: ValidateOptions(options) is OK, the kind is kQuadtree.
std::optional<QuadtreeCell> QuadtreeCellAt(const MeshOptions& options, const double* centre);

// Bounds of the local feature size.
struct FeatureSizeBounds {
  double least = 0;     // it is at least this
  double greatest = 0;  // and at most this
};
// Its bounds in `leaf`, of a quadtree of `dimension`, by guarantee 2.
FeatureSizeBounds FeatureSizeIn(const QuadtreeCell& leaf, int dimension);

}  // namespace dynmesh

#endif  // DYNMESH_QUADTREE_H_
