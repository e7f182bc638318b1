// The content of a picture of a mesh, in two coordinates. 2D: the mesh itself. 3D: its section with
// a plane across one axis: of a tetrahedron a triangle or a quadrangle, of a triangle a line.
//
// A vertex on the cutting plane counts as below it. So every tetrahedron is cut properly or not at
// all, and the sections fill the cut; subfacets in the cutting plane leave no line. Positions are
// rounded, for display. Plain data.
#ifndef DYNMESH_CORE_IO_PICTURES_MESH_PICTURE_H_
#define DYNMESH_CORE_IO_PICTURES_MESH_PICTURE_H_

#include <array>
#include <cstdint>
#include <vector>

#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

struct MeshPicture {
  using Position = std::array<double, 2>;
  struct Cell {
    std::array<std::uint32_t, 4> corners = {0, 0, 0, 0};  // the first `count`, in order around
    std::uint32_t count = 0;                              // 3 or 4
    std::uint32_t simplex = 0;                            // the simplex shown
    double light = 1;                                     // on it, 0 to 1; in perspective
    bool is_wall = false;                                 // a triangle of a polygon; in perspective
  };
  // Owned by the feature of the subsegment or cut subfacet, by the box, or by none.
  using Line = IndexedMesh::Edge;

  std::vector<Position> positions;
  std::vector<Cell> cells;
  std::vector<Line> lines;          // no duplicates
  std::vector<std::uint32_t> dots;  // positions of input points
};

// The two remaining axes, in order: x y for a cut across z.
std::array<std::size_t, 2> AxesAcross(int axis);

// O(size).
MeshPicture PictureOf(const IndexedMesh& planar);
// The section at the coordinate `position` of `axis` (0 to 2). Expected O(size).
MeshPicture CutThrough(const IndexedMesh& spatial, int axis, double position);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PICTURES_MESH_PICTURE_H_
