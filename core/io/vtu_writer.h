// Meshes as VTK's unstructured grids (.vtu), for ParaView, VisIt and meshio.
#ifndef DYNMESH_CORE_IO_VTU_WRITER_H_
#define DYNMESH_CORE_IO_VTU_WRITER_H_

#include <string>

#include "absl/status/status.h"
#include "core/io/indexed_mesh.h"

namespace dynmesh::io {

// Triangles, in space tetrahedra and after them the subfacets; values exact: inline base64,
// little-endian.
//   point data  containing_dimension; owner: the feature's id, -1 on the domain box, 0 if none
//   cell data   quality: circumradius / shortest edge; min_angle: degrees, in space dihedral;
//               exempt: 1 where an input angle too small for `rho` excuses a simplex over it, 2
//               where the termination guard does, 3 where a tetrahedron within rho has a dihedral
//               angle below `min_dihedral`, else 0;
//               radius_edge and min_angle_deg: the first two by their older names
//               in space min_dihedral: the least dihedral angle in degrees, the same as min_angle;
//               and owner: of a subfacet the feature's id, 0 of tetrahedra. The other values of
//               subfacets are no numbers or 0.
// If there are regions, also, with the numbers of region_numbers.h:
//   cell data   region: its number, 0 in no polygon
//   field data  region_polygons: the polygons' ids, region after region; region_ends: how many
//               of them there are up to and with region 1, 2, ...
// `min_dihedral` in degrees is of space, 0: no bound. UNAVAILABLE, naming the path, on trouble.
absl::Status WriteVtu(const IndexedMesh& mesh, double rho, const std::string& path,
                      double min_dihedral = 0);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_VTU_WRITER_H_
