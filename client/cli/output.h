// Writes meshes to files; the extension selects the kind.
#ifndef DYNMESH_CLIENT_CLI_OUTPUT_H_
#define DYNMESH_CLIENT_CLI_OUTPUT_H_

#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/cli/labels.h"
#include "core/io/pictures/svg_writer.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"

namespace dynmesh::cli {

struct OutputFlags {
  std::vector<std::string> paths;
  std::string fill;  // empty: depends on the other flags
  std::string crop;
  std::string cut;   // 3D: empty for the middle, else an axis and a position
  std::string clip;  // 3D, in place of `cut`: the same, in perspective
  bool legend = false;
  double width = 1000;
  int order = 1;  // of elements
  double msh_version = 4.1;
  bool binary = false;  // of a .msh
  bool from_zero = false, neighbours = false, voronoi = false;
  bool same_name = false;  // files may have the base name of the input
  int threads = 0;         // that make files at once, at most; 0: ThreadsOf chooses
};

// How many threads measure a mesh and make files at once: as the flag says, else as many as there
// are processors for this process, at most 8.
int ThreadsOf(const OutputFlags& flags);

// -o, --order, --msh-version, --binary, --zero-based, --neighbours, --voronoi, --same-name and
// --threads for meshes, and --fill, --crop, --cut, --clip, --legend and --width for pictures.
void AddOutputFlags(CLI::App& command, OutputFlags& flags);

// The options of a picture. `highlighting`: it highlights simplices.
absl::StatusOr<io::SvgOptions> PictureOptions(const OutputFlags& flags, const MeshOptions& options,
                                              bool highlighting = false);

// Checks that all paths are of a writable kind and the flags are valid. To be called before
// meshing, which may take long.
absl::Status CheckOutputs(const OutputFlags& flags);

// The same when the dimension and kind of the mesh are known.
absl::Status CheckOutputsOf(const MeshOptions& options, const OutputFlags& flags);

// INVALID_ARGUMENT if a .node and the files beside it would have the base name of the file `input`,
// unless flags.same_name: Triangle and TetGen read them with it.
absl::Status CheckNotInput(const OutputFlags& flags, const std::string& input);

// Writes every file, with `labels`. Pictures show the box of `options` unless cropped, and
// highlight the simplices `highlight`.
absl::Status WriteOutputs(const Mesh& mesh, const MeshOptions& options, const OutputFlags& flags,
                          const MeshLabels& labels = {}, const SimplexColumn& highlight = {});

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_OUTPUT_H_
