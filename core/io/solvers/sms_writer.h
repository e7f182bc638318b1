// 2D meshes as `.2dm`, for SMS, QGIS, TUFLOW, BASEMENT and other programs of water flow.
#ifndef DYNMESH_CORE_IO_SOLVERS_SMS_WRITER_H_
#define DYNMESH_CORE_IO_SOLVERS_SMS_WRITER_H_

#include <string>

#include "absl/status/status.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

// Rows in the order of the mesh, from 1:
//   E3T  number corner corner corner region    regions by their place in named_facets.h, from 1
//   ND   number x y z                          z: the first attribute of the input's points, as an
//                                              elevation; 0 without one
//   NS   vertices of a string along a set of named_facets.h, the last one negative, and the number
//        of the set from 1: from end to end, or around and back to the first; on the border with
//        the mesh on the left
// A comment (`#`) before has the name of each region and set. UNAVAILABLE, naming the path, if it
// cannot be written; INVALID_ARGUMENT as NamePartsOf. REQUIRES: dimension 2.
absl::Status WriteSms(const IndexedMesh& mesh, const std::string& path);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SOLVERS_SMS_WRITER_H_
