// Meshes as Gmsh's `.msh` 4.1 (ASCII), for Gmsh, DOLFINx, deal.II, Elmer and meshio.
#ifndef DYNMESH_CORE_IO_MESHES_MSH_WRITER_H_
#define DYNMESH_CORE_IO_MESHES_MSH_WRITER_H_

#include <string>

#include "absl/status/status.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

// Node tags are rows of the canonical order of IndexedMesh, from 1; coordinates read back bit for
// bit. Entities in 2D:
//   input point               a point with one element
//   segment, the box's border a curve with the subsegments as elements
//   everything else           surface 1, counter-clockwise triangles; in polygons, surface
//                             1 + the number of the region (region_numbers.h)
// In 3D the box's border and each polygon are surfaces with the subfacets as elements. Everything
// else is volume 1, positively oriented tetrahedra; in polygons volume 1 + the number of the
// region.
//
// Feature ids have 64 bits, so they are in the names of physical groups: "feature 30", "box".
// Surfaces (3D: volumes) have "domain", "polygon 12" and "polygons 12 40", or the name of their
// polygon (region_labels.h); each name is a group. No two groups have one name (msh_groups.h): in
// 3D the edges of polygon 30 are "feature 30 edges". Readers take at most 127 characters. A longer
// list is in a $Comments section, which they skip: "region 3: polygons 12 40 ..."; the group is
// then "region 3", by the region's number. The other groups' tags are the references of
// references.h; points, curves and surfaces of features have the same numbers as their group.
// INVALID_ARGUMENT if there are too many rows; UNAVAILABLE, naming the path, if it cannot be
// written.
// A mesh with midpoints (order 2) has elements of order 2.
absl::Status WriteMsh(const IndexedMesh& mesh, const std::string& path);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_MSH_WRITER_H_
