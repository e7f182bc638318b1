// Triangle's `.node` and `.poly` files as 2D features: points of the file become 1..n and its
// segments n+1..n+m, in file order. For 3D: space_input.h.
#ifndef DYNMESH_CORE_IO_PLANE_PLANAR_INPUT_H_
#define DYNMESH_CORE_IO_PLANE_PLANAR_INPUT_H_

#include <string>

#include "absl/status/statusor.h"
#include "core/io/common/file_features.h"
#include "core/io/common/node_input.h"
#include "core/io/common/text_reader.h"

namespace dynmesh::io {

// INVALID_ARGUMENT as `file:line: what is wrong`, UNIMPLEMENTED for 3 dimensions, NOT_FOUND and the
// like if a file cannot be read. Does not check geometry.
absl::StatusOr<FileFeatures> ReadNodeFile(const std::string& path);
// A file without vertices uses those of the `.node` beside it.
absl::StatusOr<FileFeatures> ReadPolyFile(const std::string& path);

// The same from texts in memory. Calls `open_nodes` for the vertices of a .poly without any;
// NOT_FOUND from it becomes an error of the .poly.
absl::StatusOr<FileFeatures> ParseNodeText(TextReader nodes);
absl::StatusOr<FileFeatures> ParsePolyText(TextReader poly, const OpenNodes& open_nodes);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PLANE_PLANAR_INPUT_H_
