// A 3D mesh cut open: the whole tetrahedra on the lower side of a plane across an axis, in
// perspective, as a picture of their outer triangles.
//
// Which triangle hides which is exact but for rounding: in a Delaunay tetrahedralization, of two
// tetrahedra that a line of sight meets, the nearer one's circumscribed ball has the lesser power
// to the eye. So triangles are in the order of those powers.
#ifndef DYNMESH_CORE_IO_PICTURES_CLIP_PICTURE_H_
#define DYNMESH_CORE_IO_PICTURES_CLIP_PICTURE_H_

#include <array>

#include "core/io/meshes/indexed_mesh.h"
#include "core/io/pictures/mesh_picture.h"
#include "dynmesh/options.h"

namespace dynmesh::io {

// A camera that sees `box` from the upper side of an axis.
struct ClipCamera {
  ClipCamera(const Box& box, int axis);

  // Across the picture, to the right and up, in units of the distance of the picture.
  MeshPicture::Position Project(const std::array<double, 3>& p) const;

  std::array<double, 3> eye, right, up, ahead;
};

// The triangles that face the camera, of tetrahedra whose middle is in `box` and not above
// `position` along `axis` (0 to 2): cells of three corners of their own, the farthest first, with
// the light on them. No lines, no dots. O(n lg n).
MeshPicture ClipAt(const IndexedMesh& mesh, int axis, double position, const Box& box);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PICTURES_CLIP_PICTURE_H_
