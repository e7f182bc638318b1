// Names of the parts of a mesh, by its dimension.
#ifndef DYNMESH_CLIENT_CLI_WORDS_H_
#define DYNMESH_CLIENT_CLI_WORDS_H_

#include <cstdint>
#include <string>

#include "absl/strings/str_format.h"

namespace dynmesh::cli {

constexpr const char* SimplicesWord(int dimension) {
  return dimension == 3 ? "tetrahedra" : "triangles";
}
constexpr const char* AnglesWord(int dimension) {
  return dimension == 3 ? "dihedral angles" : "angles";
}
// A line with the number of tetrahedra with an angle below the bound in degrees; empty without a
// bound.
inline std::string BelowDihedralText(std::uint64_t count, double min_dihedral) {
  if (!(min_dihedral > 0)) return "";
  return absl::StrFormat("below dihedral     %d with an angle below %.6g degrees\n", count,
                         min_dihedral);
}

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_WORDS_H_
