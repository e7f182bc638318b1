// Surfaces of graphics and CAD as features of space: `.off`, `.stl` and `.obj`. Points of the
// file become 1..n, segments follow, then a polygon of one ring for each face, in file order.
//
// .off  The header is OFF, or one of COFF, NOFF, STOFF and their combinations; counts may stand
//       on its line or on the next. Colours, normals and texture coordinates are ignored. Not
//       supported: 4OFF, nOFF and binary files.
// .stl  ASCII, and binary, which a file is when its length is that which its count of triangles
//       asks for. Corners at equal coordinates are one point (-0 is 0). Solids may be several;
//       names, normals and attribute bytes are ignored. In a binary file "lines" are triangles,
//       counted from 1.
// .obj  v, f, l and p; indices may be v, v/vt, v//vn or v/vt/vn, and negative, counting back
//       from the last vertex so far. Polylines become segments; a point element needs nothing,
//       since all vertices become points. Everything else is ignored. Not supported: lines
//       continued with \, and vertices that come after what uses them.
//
// INVALID_ARGUMENT as `file:line: what is wrong`, also for faces with a corner twice, or with
// fewer than three, and for two faces with the same corners; NOT_FOUND and the like if the file
// cannot be read. Geometry is not judged here: whether faces are flat or meet properly.
// O(file) expected time and memory. Thread-safe.
#ifndef DYNMESH_CORE_IO_SURFACE_FILES_H_
#define DYNMESH_CORE_IO_SURFACE_FILES_H_

#include <string>

#include "absl/status/statusor.h"
#include "core/io/file_features.h"
#include "core/io/text_reader.h"

namespace dynmesh::io {

absl::StatusOr<FileFeatures> ReadOffFile(const std::string& path);
absl::StatusOr<FileFeatures> ReadStlFile(const std::string& path);
absl::StatusOr<FileFeatures> ReadObjFile(const std::string& path);

// The same of a file that is there already.
absl::StatusOr<FileFeatures> ParseOffText(TextReader off);
absl::StatusOr<FileFeatures> ParseStlText(TextReader stl);
absl::StatusOr<FileFeatures> ParseObjText(TextReader obj);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SURFACE_FILES_H_
