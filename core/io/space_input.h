// `.node` files of three dimensions and TetGen's `.poly` and `.smesh` files as features: points
// of the file become 1..n, segments follow, then polygons, each in file order. Those of the
// plane: planar_input.h.
//
// A facet becomes a polygon of its polygons of three corners or more; those of two become
// segments, once each; those of one are a vertex on the facet, and vertices are points anyway.
// Inside is even-odd, so a ring in a ring is a hole; TetGen asks for a place in each hole and
// keeps the face where there is none. What the two would understand differently is not supported
// and an error: a ring that lies in an odd number of others and has no place of a hole in it, and
// a place in what even-odd keeps. So are an edge that two polygons of a facet share, a polygon
// that visits a vertex twice, two facets with the same corners, and, where holes have to be told,
// a ring that touches another one with all of its corners.
// Holes and regions of the whole are kept as places.
//
// INVALID_ARGUMENT as `file:line: what is wrong`, NOT_FOUND and the like if a file cannot be
// read. Geometry is not judged here: whether facets are flat or meet properly.
// O(file) expected time, but O(corners * rings) for a facet of many rings. Thread-safe.
#ifndef DYNMESH_CORE_IO_SPACE_INPUT_H_
#define DYNMESH_CORE_IO_SPACE_INPUT_H_

#include <string>

#include "absl/status/statusor.h"
#include "core/io/file_features.h"
#include "core/io/node_input.h"
#include "core/io/text_reader.h"

namespace dynmesh::io {

absl::StatusOr<FileFeatures> ReadSpaceNodeFile(const std::string& path);
// With no vertices of its own the file takes those of the `.node` beside it.
absl::StatusOr<FileFeatures> ReadSpacePolyFile(const std::string& path);
absl::StatusOr<FileFeatures> ReadSmeshFile(const std::string& path);

// The same of text that is there already. `open_nodes` is called for the vertices of a file that
// has none of its own; NOT_FOUND from it becomes an error of that file.
absl::StatusOr<FileFeatures> ParseSpaceNodeText(TextReader nodes);
absl::StatusOr<FileFeatures> ParseSpacePolyText(TextReader poly, const OpenNodes& open_nodes);
absl::StatusOr<FileFeatures> ParseSmeshText(TextReader smesh, const OpenNodes& open_nodes);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SPACE_INPUT_H_
