// The old and the new simplices of a patch laid over each other. Both fill the same region, the
// *cavity*; what an old and a new one have in common is a piece.
//
// A piece is known by its mixed mass matrix: the integrals of the products of the old simplex's
// barycentric coordinates with the new one's. Transfer of any kind needs no more. Where pieces
// should add up to a simplex they do but for rounding of places, and nothing here relies on more.
//
// Everything is a function of the two meshes, in the order of the patch: no slot, address or
// history shows.
#ifndef DYNMESH_CORE_TRANSFER_OVERLAY_H_
#define DYNMESH_CORE_TRANSFER_OVERLAY_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/transfer/box_tree.h"
#include "core/transfer/simplex.h"
#include "dynmesh/slot_mesh.h"

namespace dynmesh::transfer {

inline std::size_t At(Slot slot) { return static_cast<std::size_t>(slot); }

// The places of D + 1 vertices.
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

// An old and a new simplex, by their places in the overlay's lists, and what they share:
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
  // The matrix of a simplex's own coordinates, as its pieces add up to it. Symmetric.
  using Mass = std::array<double, (D + 1) * (D + 1)>;

  std::vector<PatchSimplex<D>> from, to;  // old and new simplices, in the order of the patch
  std::vector<Piece<D>> pieces;           // by `to`
  std::vector<std::uint32_t> begins;      // of the pieces of each new one, and the end
  BoxTree<D> tree;                        // of the boxes of `from`
  bool has_regions = false;               // are there several?
  // Of each new one; if there are several regions, the same over those pieces that lie in its own.
  std::vector<Mass> own, own_of_region;

  std::span<const Piece<D>> PiecesOf(std::size_t to_index) const {
    return {pieces.data() + begins[to_index], begins[to_index + 1] - begins[to_index]};
  }

  // Expected O(n lg n + p) for n simplices and p pieces.
  static Overlay Make(const SlotMesh& mesh);

  // The old simplex in which `x` lies, or as good as: the one where its least barycentric
  // coordinate is greatest. REQUIRES: there is an old one.
  struct Place {
    std::uint32_t from;
    std::array<double, D + 1> lambda;
  };
  Place Locate(const Vec<D>& x) const;

 private:
  void FindPieces();
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_OVERLAY_H_
