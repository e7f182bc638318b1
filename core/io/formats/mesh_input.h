// Meshes, leaves and target lengths in files, whatever the format: formats.h chooses by the
// extension. Errors are those of the formats' readers: INVALID_ARGUMENT as `file:line: what is
// wrong`, NOT_FOUND and the like if a file cannot be read. Thread-safe.
#ifndef DYNMESH_CORE_IO_FORMATS_MESH_INPUT_H_
#define DYNMESH_CORE_IO_FORMATS_MESH_INPUT_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/io/elements/element_mesh.h"
#include "core/io/meshes/mesh_files.h"
#include "core/io/quadtrees/leaf_list.h"
#include "core/io/sizes/size_fields.h"
#include "dynmesh/feature.h"

namespace dynmesh::io {

// Is it a mesh in one file, as other programs have them, without our comments?
bool IsElementFile(const std::string& path);
// Has the file the leaves of a quadtree?
bool IsLeafFile(const std::string& path);

// A mesh as elements with markers. A path of no such format is one of Triangle's or TetGen's files,
// or their common base name.
absl::StatusOr<ElementMesh> ReadElements(const std::string& path);

// A mesh to be measured. INVALID_ARGUMENT for a format that has none. As above, a path without a
// row is a common base name.
absl::StatusOr<MeshFiles> ReadAnyMesh(const std::string& path);

absl::StatusOr<LeafList> ReadLeaves(const std::string& path);

absl::StatusOr<std::vector<Feature>> ReadSizes(const std::string& path, const SizedInput& input);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_FORMATS_MESH_INPUT_H_
