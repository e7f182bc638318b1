// Files of the project that tests read.
#ifndef DYNMESH_TESTS_SUPPORT_SOURCE_PATH_H_
#define DYNMESH_TESTS_SUPPORT_SOURCE_PATH_H_

#include <string>
#include <string_view>

namespace dynmesh::test {

// The path of a file or folder of the project, such as "tests/golden"; of the project if empty.
// One object knows the folder, so that the others are the same in every clone.
std::string SourcePath(std::string_view below = "");

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_SOURCE_PATH_H_
