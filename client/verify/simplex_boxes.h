// The boxes around a mesh's simplices and sides. In 2D they have no third extent.
#ifndef DYNMESH_CLIENT_VERIFY_SIMPLEX_BOXES_H_
#define DYNMESH_CLIENT_VERIFY_SIMPLEX_BOXES_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/box_tree.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::cli {

using Box3 = boxes::Box<3>;

template <std::size_t N>
Box3 BoxOf(const io::IndexedMesh& mesh, const std::array<std::uint32_t, N>& corners) {
  std::array<Box3::Corner, N> positions;
  for (std::size_t i = 0; i < N; ++i) positions[i] = mesh.vertices[corners[i]].position();
  return Box3::Of(positions);
}

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_VERIFY_SIMPLEX_BOXES_H_
