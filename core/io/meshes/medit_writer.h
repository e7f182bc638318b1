// Meshes as Medit's ASCII `.mesh` (libMeshb), for Medit, MMG, FreeFEM and meshio.
#ifndef DYNMESH_CORE_IO_MESHES_MEDIT_WRITER_H_
#define DYNMESH_CORE_IO_MESHES_MEDIT_WRITER_H_

#include <string>

#include "absl/status/status.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

// MeshVersionFormatted 2 (doubles), Dimension 2 or 3, rows in the canonical order of IndexedMesh,
// numbered from 1:
// If labels replace ids, references are markers of the input; those of simplices are the whole part
// of their region's attribute if there are any, else the numbers of msh_groups.h: the markers of
// their polygons.
//   Vertices   x y [z] reference of the owner, 0 if free; coordinates read back bit for bit
//   Edges      the subsegments, with the reference of the owner
//   Triangles  2D: counter-clockwise, reference 1; in polygons 1 + the number of the
//              region (region_numbers.h). 3D: the subfacets and the other triangles of the
//              domain's border, with the reference of the owner or the box. The least number is
//              first, and the order is counter-clockwise as seen from outside of a tetrahedron
//              that has the triangle as a side. Of two, that is the one with the lesser number of
//              its region; in one region it is the one whose row is first. So triangles of the
//              mesh's border point outward, as FreeFEM demands, and those around a region all
//              point to the side with the greater number.
//   Tetrahedra 3D; positively oriented, with references as triangles in 2D
// The other references are those of references.h; comments after the dimension list them.
// INVALID_ARGUMENT if there are too many rows; UNAVAILABLE, naming the path, if it cannot be
// written.
absl::Status WriteMedit(const IndexedMesh& mesh, const std::string& path);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_MEDIT_WRITER_H_
