// The intersections of the old and the new simplices of a patch. Both fill the same region, the
// *cavity*. A piece is the intersection of an old and a new simplex.
//
// A piece is stored as its mixed mass matrix: the integrals of the products of the old simplex's
// barycentric coordinates with the new one's. All transfers need only that. The pieces of a simplex
// add up to it up to the rounding of positions; no code relies on more.
//
// Everything is a function of the two meshes, in the order of the patch, not of slots, addresses or
// history.
#ifndef DYNMESH_CORE_TRANSFER_OVERLAY_H_
#define DYNMESH_CORE_TRANSFER_OVERLAY_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/box_tree.h"
#include "core/transfer/simplex.h"
#include "dynmesh/slot_mesh.h"

namespace dynmesh::transfer {

inline std::size_t At(Slot slot) { return static_cast<std::size_t>(slot); }

// The positions of D + 1 vertices.
template <std::size_t D>
Corners<D> CornersOf(const SlotMesh& mesh, const Slot* vertices) {
  Corners<D> corners;
  for (std::size_t k = 0; k <= D; ++k) {
    std::copy_n(mesh.points().data() + At(vertices[k]) * D, D, corners[k].begin());
  }
  return corners;
}

// A simplex of the patch, old or new.
template <std::size_t D>
struct PatchSimplex {
  Slot slot;
  std::array<Slot, D + 1> vertices;
  Corners<D> corners;
  double measure;
  RegionId region;
};

template <std::size_t N>
double Total(const std::array<double, N>& terms) {
  double sum = 0;
  for (const double term : terms) sum += term;
  return sum;
}

// The intersection of an old and a new simplex, given by their indices in the overlay's lists.
// mass[a * (D + 1) + b] is the integral of the old one's coordinate a times the new one's b.
template <std::size_t D>
struct Piece {
  std::uint32_t from;
  std::uint32_t to;
  std::array<double, (D + 1) * (D + 1)> mass;
  double measure() const { return Total(mass); }
  // The integral of the old one's coordinate a.
  double share(std::size_t a) const {
    double sum = 0;
    for (std::size_t b = 0; b <= D; ++b) sum += mass[a * (D + 1) + b];
    return sum;
  }
};

template <std::size_t D>
struct Overlay {
  // The matrix of a simplex's own coordinates, summed over its pieces. Symmetric.
  using Mass = std::array<double, (D + 1) * (D + 1)>;

  std::vector<PatchSimplex<D>> from, to;  // old and new simplices, in the order of the patch
  std::vector<Piece<D>> pieces;           // by `to`
  std::vector<std::uint32_t> begins;      // of the pieces of each new simplex, and the end
  boxes::BoxTree<D> tree;                 // of the boxes of `from`
  bool has_regions = false;               // are there several?
  // Per new simplex, over all its pieces; if there are several regions, also over those in its own
  // region.
  std::vector<Mass> own, own_of_region;

  std::span<const Piece<D>> PiecesOf(std::size_t to_index) const {
    return {pieces.data() + begins[to_index], begins[to_index + 1] - begins[to_index]};
  }

  // Expected O(n lg n + p) for n simplices and p pieces.
  static Overlay Make(const SlotMesh& mesh);

  // The old simplex that contains `x`, up to rounding: the one where its least barycentric
  // coordinate is greatest. REQUIRES: there is an old simplex.
  struct Location {
    std::uint32_t from;
    std::array<double, D + 1> lambda;
  };
  Location Locate(const Vec<D>& x) const;

 private:
  void FindPieces();
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_OVERLAY_H_
