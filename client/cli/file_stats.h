// dynmesh stats MESHFILE: figures of a mesh file, or of a quadtree's leaves, in process.
#ifndef DYNMESH_CLIENT_CLI_FILE_STATS_H_
#define DYNMESH_CLIENT_CLI_FILE_STATS_H_

#include <optional>
#include <string>

#include "CLI/CLI.hpp"
#include "dynmesh/options.h"

namespace dynmesh::cli {

struct FileStatsFlags {
  std::optional<double> rho, min_dihedral;
  std::string svg;
  bool histogram = false;  // print the distribution of angles
  std::string lfs;         // the mesh's input; empty: not given
  bool log_scale = false;
  double width = 1000;
};

// --rho, --min-dihedral, --lfs, --svg, --log, --width
void AddFileStatsFlags(CLI::App& command, FileStatsFlags& flags);

// True if `name` is a file name: the id of a mesh has neither dot nor slash.
bool IsMeshFile(const std::string& name);

// Prints the figures and writes the picture, if requested. Returns the exit code.
int RunFileStats(const std::string& path, const FileStatsFlags& flags, bool json);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_FILE_STATS_H_
