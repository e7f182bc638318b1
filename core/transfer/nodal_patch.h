// The part of the new mesh that changes in a transfer of vertex values: the cavity's vertices,
// rings of vertices around them, and the simplices with these as corners.
//
// The order is that of a walk from the patch's simplices across faces: a function of the mesh.
#ifndef DYNMESH_CORE_TRANSFER_NODAL_PATCH_H_
#define DYNMESH_CORE_TRANSFER_NODAL_PATCH_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/transfer/overlay.h"
#include "core/transfer/slot_index.h"
#include "dynmesh/slot_mesh.h"

namespace dynmesh::transfer {

template <std::size_t D>
struct NodalPatch {
  struct Cell {
    std::array<std::uint32_t, D + 1> corners;  // indices of vertices here
    double measure;
    RegionId region;
  };

  std::vector<Slot> vertices;  // first the cavity's, then ring by ring
  std::size_t cavity_count;    // vertices of the cavity
  std::size_t free_count;      // these and the rings: `cells` has all simplices around them
  std::vector<Cell> cells;     // the new simplices of the overlay first, in its order
  std::vector<double> lumped;  // per free vertex: the integral of its hat function
  SlotIndex indices;           // of vertices

  NodalPatch(const SlotMesh& mesh, const Overlay<D>& overlay, int rings);

 private:
  void Measure(const SlotMesh& mesh, std::size_t first);
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_NODAL_PATCH_H_
