// Meshes, leaves of quadtrees and features to files, whatever the format: formats.h chooses by the
// extension. Either a file is complete, or the former one stays; UNAVAILABLE, naming it, if it
// cannot be written. Thread-safe.
#ifndef DYNMESH_CORE_IO_FORMATS_MESH_OUTPUT_H_
#define DYNMESH_CORE_IO_FORMATS_MESH_OUTPUT_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/io/common/feature_labels.h"
#include "core/io/common/triangle_sections.h"
#include "core/io/meshes/indexed_mesh.h"
#include "core/io/meshes/mesh_files.h"
#include "core/io/meshes/msh_writer.h"
#include "core/io/pictures/svg_writer.h"
#include "core/io/quadtrees/leaf_list.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::io {

struct MeshOutput {
  MeshFileOptions files;  // of a .node and the files beside it; bounds and threads, of all formats
  MshVersion msh_version = MshVersion::k41;
  bool binary = false;  // of a .msh
  SvgOptions picture;
  const IndexedMesh* shown = nullptr;  // in a picture, if not the mesh: it is of order 1
};

// Lets files say what a mesh of `options` was made for.
void NoteOptions(const MeshOptions& options, MeshFileOptions& files);

// INVALID_ARGUMENT unless a mesh or leaves are written with this extension; UNIMPLEMENTED for a
// .png.
absl::Status CheckMeshOutput(const std::string& path);
// The same for a mesh of this dimension and kind.
absl::Status CheckMeshOutputOf(const MeshOptions& options, const std::string& path);
// INVALID_ARGUMENT unless elements are written with this order and extension: 1, or with some 2. A
// picture of any order is that of order 1. `name` is what the caller calls the order.
absl::Status CheckOrder(int order, std::string_view name, const std::string& path);
std::string SecondOrderFormats();  // ".vtu and .msh"

// REQUIRES: the checks above are OK.
absl::Status WriteMeshFile(const IndexedMesh& mesh, const MeshOutput& output,
                           const std::string& path);
absl::Status WriteLeafFile(const LeafList& list, const MeshOutput& output, const std::string& path);

struct FeatureOutput {
  const MeshOptions& options;
  const std::vector<Feature>& features;
  const std::vector<SeedRow>& holes;
  const std::vector<SeedRow>& regions;
  const FeatureLabels& labels;
};

// INVALID_ARGUMENT unless features of this dimension are written with this extension.
absl::Status CheckFeatureOutput(int dimension, const std::string& path);

// What the format does not keep is left out (FormatFlag). INVALID_ARGUMENT if it cannot have some
// feature. REQUIRES: the check above is OK.
absl::Status WriteFeatureFile(const std::string& path, const FeatureOutput& output);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_FORMATS_MESH_OUTPUT_H_
