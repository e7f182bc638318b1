// Meshes as VTK's unstructured grids (.vtu), for ParaView, VisIt and meshio.
#ifndef DYNMESH_CORE_IO_VTU_WRITER_H_
#define DYNMESH_CORE_IO_VTU_WRITER_H_

#include <string>

#include "absl/status/status.h"
#include "core/io/indexed_mesh.h"

namespace dynmesh::io {

// Triangles with point data `containing_dimension` and `owner` (the feature's id, -1
// for the domain box, 0 for none), cell data `radius_edge` and `min_angle_deg`. Values
// are exact: inline base64, little-endian. UNAVAILABLE, naming the path, on trouble.
absl::Status WriteVtu(const IndexedMesh& mesh, const std::string& path);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_VTU_WRITER_H_
