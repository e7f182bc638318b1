// The facets of a surface file that each polygon of the prepared surface is made of, as JSON.
#ifndef DYNMESH_CLIENT_CLI_FACET_MAP_FILE_H_
#define DYNMESH_CLIENT_CLI_FACET_MAP_FILE_H_

#include <string>

#include "absl/status/status.h"
#include "client/cli/input.h"

namespace dynmesh::cli {

// Writes the map (preparation/facet_map.h) of what was made of `surface`: the number of the file's
// facets, for each polygon their indices in the file, from 0, and those of no polygon.
// INVALID_ARGUMENT if it is no surface file, or `path` is the same one; UNAVAILABLE if `path`
// cannot be written.
absl::Status WriteFacetMap(const std::string& surface, const Input& input, const std::string& path);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_FACET_MAP_FILE_H_
