// Writes traces (dynmesh/trace.h) to files: as a graph for Graphviz, or as JSON for programs.
#ifndef DYNMESH_CLIENT_CLI_TRACE_FILES_H_
#define DYNMESH_CLIENT_CLI_TRACE_FILES_H_

#include <string>

#include "absl/status/status.h"
#include "dynmesh/trace.h"

namespace dynmesh::cli {

// OK if the extension of the path is .dot or .json. To be called before meshing.
absl::Status CheckTracePath(const std::string& path);

// REQUIRES: CheckTracePath(path) is OK. UNAVAILABLE if the file cannot be written.
absl::Status WriteTrace(const Trace& trace, const std::string& path);

// The same as texts. A node of the graph is an operation. Its colour says what the last batch did
// to it. A dotted edge leads from the operation that made a vertex to one that reads it, a thin one
// from an operation to one that it requests, a thick one from a change to what ran again because of
// it.
std::string TraceAsDot(const Trace& trace);
std::string TraceAsJson(const Trace& trace);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_TRACE_FILES_H_
