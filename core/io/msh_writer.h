// Meshes as Gmsh's `.msh` 4.1 (ASCII), for Gmsh, DOLFINx, deal.II, Elmer and meshio.
#ifndef DYNMESH_CORE_IO_MSH_WRITER_H_
#define DYNMESH_CORE_IO_MSH_WRITER_H_

#include <string>

#include "absl/status/status.h"
#include "core/io/indexed_mesh.h"

namespace dynmesh::io {

// Node tags are rows of the canonical order of IndexedMesh, from 1; coordinates read back bit
// for bit. What is made of what:
//   input point               a point with one element
//   segment, the box's border a curve with the subsegments as elements
//   everything else           surface 1, counter-clockwise triangles; in polygons, surface
//                             1 + the number of the region (region_numbers.h)
// In space the box's border is a surface, and so is each polygon, with the subfacets as elements;
// everything else is volume 1, positively oriented tetrahedra, or volumes as surfaces above.
// Feature ids, which have 64 bits, stand in the names of physical groups: "feature 30",
// "box"; "domain", "polygon 12" and "polygons 12 40" for surfaces, in space volumes, each of which
// is a group of its own. A list that makes a name of more than 127 characters, the most that
// readers take, stands in a $Comments section, which they skip: "region 3: polygons 12 40 ..."; the
// group is "region 3", by the region's number. The other groups' tags are the references of
// references.h; points and curves of features have the same numbers as their group, surfaces too.
// INVALID_ARGUMENT if there are too many rows, UNAVAILABLE, naming the path, on trouble.
absl::Status WriteMsh(const IndexedMesh& mesh, const std::string& path);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MSH_WRITER_H_
