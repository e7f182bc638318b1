// The version that the server reports.
#ifndef DYNMESH_SERVER_VERSION_H_
#define DYNMESH_SERVER_VERSION_H_

namespace dynmesh::server {

inline constexpr char kVersion[] = DYNMESH_VERSION;  // defined by CMake

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_VERSION_H_
