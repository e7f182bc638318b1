// Which simplices share a face: fills a column of neighbours, by the slots of corners.
//
// Where more than two simplices share a face, as in no mesh, two of them become neighbours.
#ifndef DYNMESH_CORE_DATA_FACE_LINKS_H_
#define DYNMESH_CORE_DATA_FACE_LINKS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dynmesh/slot_mesh.h"

namespace dynmesh::data {

// The faces of a change: those of simplices that come, and those that kept simplices had in common
// with simplices that went. One thread.
class FaceLinks {
 public:
  // The face of the simplex with `width` corners that is opposite of its corner k. It is that of
  // `simplex` opposite of its corner `side`.
  void Add(const Slot* corners, std::size_t width, std::size_t k, Slot simplex, std::size_t side);

  // Makes neighbours of simplices that have a face in common. `neighbours` has `width` entries a
  // simplex. Expected O(f) for f faces. REQUIRES: called once, after all Add.
  void Link(Slot* neighbours, std::size_t width);

 private:
  struct Face {
    std::array<Slot, 3> corners;  // ascending; in the plane the first two
    Slot simplex;
    std::uint32_t side;
  };
  std::vector<Face> faces_;
};

// The same for all of `cells`, rows of `width` slots below `vertex_count`. Expected O(cells).
void LinkAllFaces(std::span<const Slot> cells, std::size_t width, std::size_t vertex_count,
                  Slot* neighbours);

}  // namespace dynmesh::data

#endif  // DYNMESH_CORE_DATA_FACE_LINKS_H_
