// Flags that add sizing features to an input: --size, --size-of, --grade.
#ifndef DYNMESH_CLIENT_CLI_SIZE_FLAGS_H_
#define DYNMESH_CLIENT_CLI_SIZE_FLAGS_H_

#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "client/cli/input.h"

namespace dynmesh::cli {

struct SizeFlags {
  std::vector<std::string> files;   // --size FILE
  std::vector<std::string> of;      // --size-of IDS=H
  std::vector<std::string> grades;  // --grade IDS=HMIN,HMAX,DMIN,DMAX
};
void AddSizeFlags(CLI::App& command, SizeFlags& flags);

// Adds the features to `input`, with ids above all others; input.where names the flag. To be called
// when its box is known. INVALID_ARGUMENT for a bad flag, file, or id.
absl::Status ApplySizeFlags(const SizeFlags& flags, Input& input);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_SIZE_FLAGS_H_
