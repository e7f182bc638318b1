// The neighbourhood of each old simplex of a patch, and the gradient of a field of means there.
//
// A stencil is two rings of neighbours across faces on the old mesh, in the simplex's region: nine
// triangles or sixteen tetrahedra. It has more rings if these are coplanar or collinear, as in
// corners. Simplices that the edit kept are looked up in the mesh.
#ifndef DYNMESH_CORE_TRANSFER_STENCIL_H_
#define DYNMESH_CORE_TRANSFER_STENCIL_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/transfer/overlay.h"
#include "core/transfer/simplex.h"
#include "dynmesh/slot_mesh.h"

namespace dynmesh::transfer {

template <std::size_t D>
class Stencil {
 public:
  Stencil(const SlotMesh& mesh, const Overlay<D>& overlay);

  // Slots of the kept simplices in stencils. Values of a field are first those of the overlay's old
  // simplices, then those of these.
  std::span<const Slot> kept() const { return kept_; }

  // The limited gradient of the linear function with the mean of old simplex i. Exact for linear
  // fields. Where the means are not smooth, the function at the simplex's corners stays within the
  // range of the stencil's means.
  Vec<D> Gradient(std::size_t i, std::span<const double> values) const;

  const Vec<D>& centroid(std::size_t i) const { return centroids_[i]; }

 private:
  std::vector<Slot> kept_;
  std::vector<Vec<D>> centroids_;                       // of the old simplices, then of `kept_`
  std::vector<std::vector<std::uint32_t>> neighbours_;  // by old simplex
  const Overlay<D>& overlay_;
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_STENCIL_H_
