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
// Of the exempt triangles, those that unsplit segments excuse.
inline std::string ByUnsplitText(std::uint64_t count) {
  return count == 0 ? "" : absl::StrFormat(", %d by unsplit segments", count);
}

// A line with the number of tetrahedra with an angle below the bound in degrees; empty without a
// bound.
// `exempt`: those below because of small angles of the input, which do not count.
inline std::string BelowDihedralText(std::uint64_t count, std::uint64_t exempt,
                                     double min_dihedral) {
  if (!(min_dihedral > 0)) return "";
  const std::string more =
      exempt == 0 ? "" : absl::StrFormat(", %d exempt at small angles of the input", exempt);
  return absl::StrFormat("below dihedral     %d with an angle below %.6g degrees%s\n", count,
                         min_dihedral, more);
}

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_WORDS_H_
