// Finds simplices that share a face: fills a column of neighbours, by the slots of corners.
//
// If more than two simplices share a face, as in no valid mesh, two of them become neighbours.
#ifndef DYNMESH_CORE_MESH_DATA_FACE_LINKS_H_
#define DYNMESH_CORE_MESH_DATA_FACE_LINKS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dynmesh/slot_mesh.h"

namespace dynmesh::mesh_data {

// The faces of a change: those of added simplices, and those that kept simplices shared with
// removed ones. One thread.
class FaceLinks {
 public:
  // Adds the face opposite to corner k of the simplex with `width` `corners`. It is the face of
  // `simplex` opposite to its corner `side`.
  void Add(const Slot* corners, std::size_t width, std::size_t k, Slot simplex, std::size_t side);

  // Makes simplices with a common face neighbours. `neighbours` has `width` entries per simplex.
  // Expected O(f) for f faces. REQUIRES: called once, after all Add.
  void Link(Slot* neighbours, std::size_t width);

 private:
  struct Face {
    std::array<Slot, 3> corners;  // ascending; in 2D the first two
    Slot simplex;
    std::uint32_t side;
  };
  std::vector<Face> faces_;
};

// The same for all of `cells`: rows of `width` slots below `vertex_count`. Expected O(cells).
void LinkAllFaces(std::span<const Slot> cells, std::size_t width, std::size_t vertex_count,
                  Slot* neighbours);

}  // namespace dynmesh::mesh_data

#endif  // DYNMESH_CORE_MESH_DATA_FACE_LINKS_H_
