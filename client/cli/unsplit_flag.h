// The flag --unsplit: segments and polygons of an input that are to stay whole (Feature::unsplit).
#ifndef DYNMESH_CLIENT_CLI_UNSPLIT_FLAG_H_
#define DYNMESH_CLIENT_CLI_UNSPLIT_FLAG_H_

#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "dynmesh/feature.h"

namespace dynmesh::cli {

// `ids`: of segments and polygons, with commas between them, or "all".
void AddUnsplitFlag(CLI::App& command, std::string& ids);

// Marks those of the features, beside what is marked already. Nothing if `ids` is empty.
// INVALID_ARGUMENT for what is no id of a segment or polygon.
absl::Status ApplyUnsplitFlag(const std::string& ids, std::vector<Feature>& features);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_UNSPLIT_FLAG_H_
