// Meshes as VTK's unstructured grids (.vtu), for ParaView, VisIt and meshio.
#ifndef DYNMESH_CORE_IO_MESHES_VTU_WRITER_H_
#define DYNMESH_CORE_IO_MESHES_VTU_WRITER_H_

#include <string>

#include "absl/status/status.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

// Triangles, or in 3D tetrahedra followed by the subfacets. Values are exact: inline base64,
// little-endian.
//   point data  containing_dimension; owner: the feature's id, -1 on the domain box, 0 if none
//   cell data   quality: circumradius / shortest edge; min_angle: degrees, in 3D dihedral;
//               exempt: of a simplex over `rho`, 1 if excused by a small input angle, 2 by the
//               termination guard; 3 of a tetrahedron within rho with a dihedral angle below
//               `min_dihedral`; else 0;
//               radius_edge and min_angle_deg: older names of the first two;
//               in 3D min_dihedral: the least dihedral angle in degrees, equal to min_angle;
//               and owner: of a subfacet the feature's id, 0 of tetrahedra. The other values of
//               subfacets are NaN or 0.
// If there are regions, with the numbers of region_numbers.h:
//   cell data   region: its number, 0 in no polygon
//   field data  region_polygons: the polygons' ids, region by region; region_ends: their
//               number up to and including region 1, 2, ...
// `min_dihedral` in degrees is for 3D; 0: no bound. UNAVAILABLE, naming the path, if it cannot be
// written.
absl::Status WriteVtu(const IndexedMesh& mesh, double rho, const std::string& path,
                      double min_dihedral = 0);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_VTU_WRITER_H_
