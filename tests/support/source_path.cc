#include "tests/support/source_path.h"

namespace dynmesh::test {

std::string SourcePath(std::string_view below) {
  std::string path = DYNMESH_SOURCE_DIR;
  if (!below.empty()) path.append("/").append(below);
  return path;
}

}  // namespace dynmesh::test
