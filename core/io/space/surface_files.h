// Surfaces of graphics and CAD as 3D features: `.off`, `.stl` and `.obj`. Points of the file become
// 1..n; segments follow, then a polygon of one ring for each face, in file order.
//
// .off  The header is OFF, or one of COFF, NOFF, STOFF and their combinations; counts are on
//       its line or on the next. Colours, normals and texture coordinates are ignored. Not
//       supported: 4OFF, nOFF and binary files.
// .stl  ASCII or binary. A file is binary iff its length fits its count of triangles. Corners
//       with equal coordinates are one point (-0 is 0). Several solids are allowed; names,
//       normals and attribute bytes are ignored. In a binary file "lines" are triangles,
//       counted from 1.
// .obj  v, f, l and p; indices are v, v/vt, v//vn or v/vt/vn; negative ones count back from
//       the last vertex so far. Polylines become segments. Point elements add nothing, since all
//       vertices become points. Everything else is ignored. Not supported: lines continued
//       with \, and vertices after their first use.
//
// INVALID_ARGUMENT as `file:line: what is wrong`, also for a face with a repeated corner or fewer
// than three, and for two faces with the same corners. NOT_FOUND and the like if the file cannot be
// read. Does not check geometry, such as flat faces or their intersections. O(file) expected time
// and memory. Thread-safe.
#ifndef DYNMESH_CORE_IO_SPACE_SURFACE_FILES_H_
#define DYNMESH_CORE_IO_SPACE_SURFACE_FILES_H_

#include <string>

#include "absl/status/statusor.h"
#include "core/io/common/file_features.h"
#include "core/io/common/text_reader.h"

namespace dynmesh::io {

absl::StatusOr<FileFeatures> ReadOffFile(const std::string& path);
absl::StatusOr<FileFeatures> ReadStlFile(const std::string& path);
absl::StatusOr<FileFeatures> ReadObjFile(const std::string& path);

// The same from texts in memory.
absl::StatusOr<FileFeatures> ParseOffText(TextReader off);
absl::StatusOr<FileFeatures> ParseStlText(TextReader stl);
absl::StatusOr<FileFeatures> ParseObjText(TextReader obj);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SPACE_SURFACE_FILES_H_
