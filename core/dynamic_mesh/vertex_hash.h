// How public ids of vertices are made of coordinates.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_VERTEX_HASH_H_
#define DYNMESH_CORE_DYNAMIC_MESH_VERTEX_HASH_H_

#include <cstdint>

#include "dynmesh/mesh.h"

namespace dynmesh {

// VertexIdAt. Tests use a poor hash, to make collisions.
using VertexHash = VertexId (*)(const double* coordinates, int dimension, std::uint64_t salt);

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_VERTEX_HASH_H_
