// What a picture of a mesh shows, in two coordinates: the mesh itself in the plane; in space
// where a plane across one axis cuts it: of a tetrahedron a triangle or a quadrangle, of a
// triangle a line.
//
// A vertex on the cutting plane counts as below it, so every tetrahedron is cut in a proper way
// or not at all, and what is cut fills the cut; subfacets in the cutting plane leave no line.
// Places are rounded: they are to be looked at. Plain data.
#ifndef DYNMESH_CORE_IO_MESH_PICTURE_H_
#define DYNMESH_CORE_IO_MESH_PICTURE_H_

#include <array>
#include <cstdint>
#include <vector>

#include "core/io/indexed_mesh.h"

namespace dynmesh::io {

struct MeshPicture {
  using Place = std::array<double, 2>;
  struct Cell {
    std::array<std::uint32_t, 4> corners = {0, 0, 0, 0};  // the first `count`, in order around
    std::uint32_t count = 0;                              // 3 or 4
    std::uint32_t simplex = 0;                            // what it shows
  };
  // Of the feature whose subsegment it is or whose subfacet leaves it, of the box, or of none.
  using Line = IndexedMesh::Edge;

  std::vector<Place> places;
  std::vector<Cell> cells;
  std::vector<Line> lines;          // once each
  std::vector<std::uint32_t> dots;  // places of input points
};

// The axes that are left, in order: x y for a cut across z.
std::array<std::size_t, 2> AxesAcross(int axis);

// O(size).
MeshPicture PictureOf(const IndexedMesh& planar);
// Where `axis` (0 to 2) has the coordinate `position`. Expected O(size).
MeshPicture CutThrough(const IndexedMesh& spatial, int axis, double position);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESH_PICTURE_H_
