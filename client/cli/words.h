// What the parts of a mesh are called, by its dimension.
#ifndef DYNMESH_CLIENT_CLI_WORDS_H_
#define DYNMESH_CLIENT_CLI_WORDS_H_

namespace dynmesh::cli {

constexpr const char* SimplicesWord(int dimension) {
  return dimension == 3 ? "tetrahedra" : "triangles";
}
constexpr const char* AnglesWord(int dimension) {
  return dimension == 3 ? "dihedral angles" : "angles";
}

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_WORDS_H_
