// What a mesh refuses of an input: not only the first fault.
#ifndef DYNMESH_CLIENT_CLI_REFUSALS_H_
#define DYNMESH_CLIENT_CLI_REFUSALS_H_

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/input.h"

namespace dynmesh::cli {

// What a mesh refuses, found by leaving out, again and again, what is to blame.
struct Refusals {
  std::size_t count = 0;
  std::map<std::string, std::size_t> by_reason;  // of dynmesh/error.h
  std::vector<absl::Status> first;               // kMostTold at most
  bool is_complete = true;                       // else the search ended before
};
inline constexpr std::size_t kMostTold = 10;
// Ends after the first kMostTold, if not `all` are wanted. Each takes a validation of the rest.
Refusals FindRefusals(const std::vector<Feature>& features, const MeshOptions& options, bool all);

// How an input was read, and which refusals are wanted.
struct RefusalWishes {
  bool is_merged = false, is_refined = false;
  bool all = false;
  std::optional<double> mended_within;  // mending within this did not help
  std::string mending = "`dynmesh import INPUT --clean -o CLEAN.poly`";  // what mends the input
};
// Reports `first`, the refusal of `input` by a mesh with its options, then others as FindRefusals
// finds them: kMostTold are told, all found are counted. Of a 3D surface whose faces could be
// joined it says that `--merge-coplanar` does so; of what cleaning mends, how, or that mending has
// been tried; nothing of a mesh that is refined. Returns the exit code. Only
// features are looked at; other errors are reported alone.
int ReportRefusals(const absl::Status& first, const Input& input, const RefusalWishes& wishes);

// Reports an error about a mesh that is too large, where it is finest, and which tolerance of
// cleaning joins what is so near there. `why`: of the limit of
// vertices, if it is not the user's.
// Returns the exit code.
int ReportTooLarge(const absl::Status& error, const Input& input, const std::string& why);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_REFUSALS_H_
