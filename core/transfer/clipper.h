// What an old simplex and a new one share: the piece's mixed mass matrix, and across which faces of
// the old one the new one goes on. For overlay.cc alone.
#ifndef DYNMESH_CORE_TRANSFER_CLIPPER_H_
#define DYNMESH_CORE_TRANSFER_CLIPPER_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/transfer/clip.h"
#include "core/transfer/overlay.h"
#include "core/transfer/simplex.h"

namespace dynmesh::transfer {

// A new simplex, ready to clip old ones. Everything is computed relative to one of its corners, so
// that rounding is that of distances.
template <std::size_t D>
class Clipper {
 public:
  explicit Clipper(const PatchSimplex<D>& to)
      : origin_(to.corners[0]),
        corners_(Relative(to.corners)),
        halves_(HalfSpaces(corners_)),
        coordinates_(corners_),
        extent_(ExtentOf(corners_)) {}

  // Returns false if they have nothing in common, or rounding alone. Otherwise fills `piece.mass`,
  // puts into `own` what the piece is of the new simplex, and into `open` the bits of the old one's
  // faces that the piece has a side on: face k is opposite of corner k.
  bool Clip(const PatchSimplex<D>& from, Piece<D>& piece, typename Overlay<D>::Mass& own,
            std::uint32_t& open) const {
    const Corners<D> old = Relative(from.corners);
    const double extent = std::max(extent_, ExtentOf(old));
    std::array<double, D + 1> noise;
    for (std::size_t k = 0; k <= D; ++k) {
      noise[k] = halves_[k].Noise(extent);
      bool any_in = false;
      for (const Vec<D>& corner : old) any_in |= halves_[k](corner) > noise[k];
      if (!any_in) return false;
    }
    Clipped<D> clipped(old);
    for (std::size_t k = 0; k <= D; ++k) {
      if (!clipped.By(halves_[k], noise[k])) return false;
    }
    return Integrate(clipped, piece, own, open);
  }

 private:
  // Coordinates in the old and in the new simplex.
  struct TwoCoordinates {
    std::array<double, D + 1> old, own;
  };

  // The integral of f g, both linear, over a simplex is its measure / ((D + 1) (D + 2)) times
  // (sum of f g at its corners + sum of f times sum of g). The first part is gathered by corner.
  bool Integrate(const Clipped<D>& clipped, Piece<D>& piece, typename Overlay<D>::Mass& own,
                 std::uint32_t& open) const {
    constexpr double kShare = 1.0 / ((D + 1) * (D + 2));
    std::array<double, Clipped<D>::kMost> weights;
    std::array<TwoCoordinates, Clipped<D>::kMost> at;
    ForEachBit(clipped.in_use(), [&](std::size_t corner) {
      weights[corner] = 0;
      at[corner] = {clipped.corner(corner).lambda, coordinates_(clipped.corner(corner).place)};
    });
    typename Overlay<D>::Mass mixed{}, mine{};  // here, where nothing else can point to
    bool any = false;
    clipped.ForEachSimplex([&](const std::array<std::size_t, D + 1>& corners) {
      Corners<D> places;
      for (std::size_t k = 0; k <= D; ++k) places[k] = clipped.corner(corners[k]).place;
      const double share = kShare * Measure<D>(places);
      any |= share > 0;
      TwoCoordinates sum{};
      for (const std::size_t corner : corners) {
        weights[corner] += share;
        for (std::size_t k = 0; k <= D; ++k) {
          sum.old[k] += at[corner].old[k], sum.own[k] += at[corner].own[k];
        }
      }
      AddProducts(share, sum, mixed, mine);
    });
    std::array<std::size_t, D + 1> on_face{};  // corners
    ForEachBit(clipped.in_use(), [&](std::size_t corner) {
      AddProducts(weights[corner], at[corner], mixed, mine);
      // A cut leaves a coordinate that is 0 at both ends exactly 0.
      for (std::size_t k = 0; k <= D; ++k) on_face[k] += at[corner].old[k] == 0;
    });
    piece.mass = mixed, own = mine;
    open = 0;
    for (std::size_t k = 0; k <= D; ++k) open |= std::uint32_t{on_face[k] >= D} << k;
    return any;
  }

  // Adds weight times the products of `c`.
  static void AddProducts(double weight, const TwoCoordinates& c, typename Overlay<D>::Mass& mass,
                          typename Overlay<D>::Mass& own) {
    constexpr std::size_t kCorners = D + 1;
    for (std::size_t a = 0; a < kCorners; ++a) {
      const double old_a = weight * c.old[a], own_a = weight * c.own[a];
      for (std::size_t b = 0; b < kCorners; ++b) mass[a * kCorners + b] += old_a * c.own[b];
      for (std::size_t b = 0; b < kCorners; ++b) own[a * kCorners + b] += own_a * c.own[b];
    }
  }

  Corners<D> Relative(const Corners<D>& corners) const {
    Corners<D> result;
    for (std::size_t k = 0; k <= D; ++k) result[k] = corners[k] - origin_;
    return result;
  }

  // The greatest coordinate.
  static double ExtentOf(const Corners<D>& corners) {
    double extent = 0;
    for (const Vec<D>& corner : corners) {
      for (const double c : corner) extent = std::max(extent, std::abs(c));
    }
    return extent;
  }

  Vec<D> origin_;
  Corners<D> corners_;
  std::array<HalfSpace<D>, D + 1> halves_;
  Barycentric<D> coordinates_;
  double extent_;
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_CLIPPER_H_
