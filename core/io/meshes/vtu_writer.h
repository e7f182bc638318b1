// Meshes as VTK's unstructured grids (.vtu), for ParaView, VisIt and meshio.
#ifndef DYNMESH_CORE_IO_MESHES_VTU_WRITER_H_
#define DYNMESH_CORE_IO_MESHES_VTU_WRITER_H_

#include <string>

#include "absl/status/status.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

// Triangles followed by the subsegments of features, or in 3D tetrahedra followed by the subfacets.
// A mesh with midpoints (order 2) has quadratic cells. Values are exact: inline base64 of
// little-endian bytes, compressed by zlib. "Subfacets" below are the subsegments in 2D.
//   point data  containing_dimension; owner: the feature's id, -1 on the domain box, 0 if none
//   cell data   quality: circumradius / shortest edge; min_angle: degrees, in 3D dihedral;
//               exempt: of a simplex over `rho`, 1 if excused by a small input angle, 2 by the
//               termination guard; 3 of a tetrahedron within rho with a dihedral angle below
//               `min_dihedral`; else 0;
//               radius_edge and min_angle_deg: older names of the first two;
//               in 3D min_dihedral: the least dihedral angle in degrees, equal to min_angle;
//               owner: of a subfacet the feature's id, 0 of simplices. The other values of
//               subfacets are NaN or 0.
// If the mesh has labels, whether or not they replace ids:
//   point data  marker; attribute: those of vertices
//   cell data   marker: of subfacets, of simplices that of region_labels.h; attribute: of regions,
//               0 of subfacets
//   field data  an array by the name of each name, with the ids of the features that have it
// If there are regions, with the numbers of region_numbers.h:
//   cell data   region: its number, 0 in no polygon
//   field data  region_polygons: the polygons' ids, region by region; region_ends: their
//               number up to and including region 1, 2, ...
// `min_dihedral` in degrees is for 3D; 0: no bound. UNAVAILABLE, naming the path, if it cannot be
// written. Up to `threads` threads measure and compress at once; no byte depends on it.
absl::Status WriteVtu(const IndexedMesh& mesh, double rho, const std::string& path,
                      double min_dihedral = 0, int threads = 1);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_VTU_WRITER_H_
