// Surfaces of graphics and CAD as 3D features: `.off`, `.stl`, `.obj` and `.ply`. Points of the
// file become 1..n; segments follow, then a polygon of one ring for each face, in file order.
//
// .off  The header is OFF, or one of COFF, NOFF, STOFF and their combinations; counts are on
//       its line or on the next. Colours, normals and texture coordinates are ignored. Not
//       supported: 4OFF, nOFF and binary files.
// .stl  ASCII or binary. A file is binary iff its length fits its count of triangles, or is less
//       than a triangle more. Corners with equal coordinates are one point (-0 is 0). Several
//       solids are allowed; names, normals and attribute bytes are ignored. In a binary file
//       "lines" are triangles, counted from 1.
// .obj  v, f, l and p; indices are v, v/vt, v//vn or v/vt/vn; negative ones count back from
//       the last vertex so far. Polylines become segments. Point elements add nothing, since all
//       vertices become points. A line that ends in \ goes on. Everything else is ignored. Not
//       supported: vertices after their first use.
// .ply  ASCII or binary, of either byte order. Vertices need x, y and z, faces the list
//       vertex_indices (or vertex_index), edges vertex1 and vertex2: those become segments. Other
//       properties and elements are ignored. Not supported: tristrips. In a binary file "lines"
//       are rows of their element, counted from 1; errors name the byte, the element and its row,
//       from 0, instead of a line.
//
// INVALID_ARGUMENT as `file:line: what is wrong`, also for a face with a repeated corner or fewer
// than three, and for two faces with the same corners, unless FaceRules takes faces as they come.
// NOT_FOUND and the like if the file cannot be
// read. Does not check geometry, such as flat faces or their intersections. O(file) expected time
// and memory. Thread-safe.
#ifndef DYNMESH_CORE_IO_SPACE_SURFACE_FILES_H_
#define DYNMESH_CORE_IO_SPACE_SURFACE_FILES_H_

#include <string>

#include "absl/status/statusor.h"
#include "core/io/common/file_features.h"
#include "core/io/common/text_reader.h"
#include "core/io/space/face_rules.h"

namespace dynmesh::io {

absl::StatusOr<FileFeatures> ReadOffFile(const std::string& path,
                                         FaceRules rules = FaceRules::kStrict);
absl::StatusOr<FileFeatures> ReadStlFile(const std::string& path,
                                         FaceRules rules = FaceRules::kStrict);
absl::StatusOr<FileFeatures> ReadObjFile(const std::string& path,
                                         FaceRules rules = FaceRules::kStrict);
absl::StatusOr<FileFeatures> ReadPlyFile(const std::string& path,
                                         FaceRules rules = FaceRules::kStrict);

// The same from texts in memory.
absl::StatusOr<FileFeatures> ParseOffText(TextReader off, FaceRules rules = FaceRules::kStrict);
absl::StatusOr<FileFeatures> ParseStlText(TextReader stl, FaceRules rules = FaceRules::kStrict);
absl::StatusOr<FileFeatures> ParseObjText(TextReader obj, FaceRules rules = FaceRules::kStrict);
absl::StatusOr<FileFeatures> ParsePlyText(TextReader ply, FaceRules rules = FaceRules::kStrict);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SPACE_SURFACE_FILES_H_
