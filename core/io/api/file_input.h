// The geometry of a file in the form of the public functions (dynmesh/files.h).
#ifndef DYNMESH_CORE_IO_API_FILE_INPUT_H_
#define DYNMESH_CORE_IO_API_FILE_INPUT_H_

#include "core/io/formats/geometry.h"
#include "dynmesh/files.h"

namespace dynmesh::io {

// Markers and names become labels of features. O(n lg n). Pure, thread-safe.
FileInput InputOf(Geometry geometry);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_API_FILE_INPUT_H_
