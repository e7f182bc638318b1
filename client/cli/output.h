// Meshes into files, the kind chosen by extension.
#ifndef DYNMESH_CLIENT_CLI_OUTPUT_H_
#define DYNMESH_CLIENT_CLI_OUTPUT_H_

#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"

namespace dynmesh::cli {

struct OutputFlags {
  std::vector<std::string> paths;
  std::string fill;  // empty: by what is to be seen
  std::string crop;
  std::string cut;  // of space: empty for the middle, else an axis and a place
  double width = 1000;
};

// -o, and --fill --crop --cut --width for pictures.
void AddOutputFlags(CLI::App& command, OutputFlags& flags);

// Are all paths of a kind that can be written, and the flags in order? Ask first: it
// is a pity to mesh for an hour and then not to know where to.
absl::Status CheckOutputs(const OutputFlags& flags);

// The same once the dimension of the mesh (2 or 3) is known.
absl::Status CheckOutputsOf(int dimension, const OutputFlags& flags);

// Writes every file. Pictures show the box of `options` unless cropped, and let the
// simplices `highlight` stand out.
absl::Status WriteOutputs(const Mesh& mesh, const MeshOptions& options, const OutputFlags& flags,
                          const SimplexColumn& highlight = {});

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_OUTPUT_H_
