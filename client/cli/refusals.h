// What a mesh refuses of an input: not only the first fault.
#ifndef DYNMESH_CLIENT_CLI_REFUSALS_H_
#define DYNMESH_CLIENT_CLI_REFUSALS_H_

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/input.h"

namespace dynmesh::cli {

// What a mesh refuses, found by leaving out, again and again, what is to blame.
struct Refusals {
  std::size_t count = 0;
  std::map<std::string, std::size_t> by_reason;  // of dynmesh/error.h
  std::vector<absl::Status> first;               // some of them
  bool is_complete = true;                       // else there are more: it took too long
};
// `most_work` bounds the time: features looked at.
Refusals FindRefusals(const std::vector<Feature>& features, const MeshOptions& options,
                      std::size_t most_work);

// Reports `first`, the refusal of `input` by a mesh with its options, then as many others as are
// found by leaving out, again and again, what is to blame: the first ten are told, all are counted
// up to a limit. Of a 3D surface whose faces could be joined it says that `--merge-coplanar` does
// so, and of what `import --clean` mends, that it does; neither of a mesh that is refined. Returns
// the exit code. Only features are looked at; other errors are reported alone.
int ReportRefusals(const absl::Status& first, const Input& input, bool is_merged, bool is_refined);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_REFUSALS_H_
