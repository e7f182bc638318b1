// The extension of a path, which determines the kind of file. Pure, thread-safe.
#ifndef DYNMESH_CORE_IO_COMMON_EXTENSION_H_
#define DYNMESH_CORE_IO_COMMON_EXTENSION_H_

#include <filesystem>
#include <string>

namespace dynmesh::io {

// With its dot, in lower case: some systems write part.stl as PART.STL. Empty if there is none.
inline std::string ExtensionOf(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return extension;
}

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COMMON_EXTENSION_H_
