// The overlap of an old simplex and a new one: the piece's mixed mass matrix, and the faces of the
// old simplex across which the new one continues. Only for overlay.cc and dual_transfer.cc.
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

// The matrix of the integrals of f_a f_b over a piece, for N functions that are linear there:
// at(corner) returns their values. `measure` is that of the clipped simplex.
//
// For a simplex it is measure / ((D + 1) (D + 2)) times (sum of f_a f_b at its corners + sum of f_a
// times sum of f_b). The first part is gathered by corner.
template <std::size_t N, std::size_t D, class AtCorner>
std::array<double, N * N> Moments(const Clipped<D>& clipped, double measure, const AtCorner& at) {
  const double scale = measure / ((D + 1) * (D + 2));
  std::array<double, N * N> moments{};
  const auto add = [&moments](double weight, const std::array<double, N>& f) {
    for (std::size_t a = 0; a < N; ++a) {
      const double weighted = weight * f[a];
      for (std::size_t b = 0; b < N; ++b) moments[a * N + b] += weighted * f[b];
    }
  };
  std::array<double, Clipped<D>::kMost> weights;
  ForEachBit(clipped.in_use(), [&](std::size_t corner) { weights[corner] = 0; });
  clipped.ForEachSimplex([&](const std::array<std::size_t, D + 1>& corners) {
    Corners<D> positions;
    for (std::size_t i = 0; i <= D; ++i) {
      const auto& lambda = clipped.corner(corners[i]).lambda;
      for (std::size_t k = 0; k < D; ++k) positions[i][k] = lambda[k + 1];
    }
    const double share = scale * std::max(0.0, ScaledMeasure(positions));
    std::array<double, N> sum{};
    for (const std::size_t corner : corners) {
      weights[corner] += share;
      for (std::size_t a = 0; a < N; ++a) sum[a] += at(corner)[a];
    }
    add(share, sum);
  });
  ForEachBit(clipped.in_use(), [&](std::size_t corner) { add(weights[corner], at(corner)); });
  return moments;
}

// A new simplex, prepared to clip old ones. All computations are relative to one of its corners, so
// rounding is that of distances.
template <std::size_t D>
class Clipper {
 public:
  using Mass = typename Overlay<D>::Mass;

  explicit Clipper(const PatchSimplex<D>& to)
      : origin_(to.corners[0]),
        corners_(Relative(to.corners)),
        scaled_measure_(ScaledMeasure(corners_)),
        extent_(ExtentOf(corners_)) {
    const auto halves = HalfSpaces(corners_);
    for (std::size_t k = 0; k <= D; ++k) {
      for (std::size_t axis = 0; axis < D; ++axis) normals_[axis][k] = halves[k].normal[axis];
      offsets_[k] = Dot(halves[k].normal, halves[k].on_plane);
      noises_[k] = halves[k].Noise(1);
    }
  }

  // Returns false if they have nothing in common, up to rounding. Otherwise fills `piece.mass`,
  // writes the piece's part of the new simplex to `own`, and to `open` the bits of the old
  // simplex's faces on which the piece has a side: face k is opposite to corner k.
  bool Clip(const PatchSimplex<D>& from, Piece<D>& piece, Mass& own, std::uint32_t& open) const {
    const Corners<D> old = Relative(from.corners);
    ByFace noise;
    const ClipValues<D> values = ValuesAt(old);
    Clipped<D> clipped(values);
    if (!Cut(old, values, noise, clipped)) return false;
    open = clipped.Sides();
    return *std::max_element(noise.begin(), noise.end()) > kFine * scaled_measure_
               ? IntegrateAtPositions(clipped, old, from.measure, piece.mass, own)
               : Integrate(clipped, values, from.measure, piece.mass, own);
  }

  // Calls visit(old coordinates, new coordinates, measure) for each simplex of a triangulation of
  // the piece; coordinates are barycentric, by its corner.
  template <class Visit>
  void ForEachSimplex(const PatchSimplex<D>& from, const Visit& visit) const {
    using Coordinates = std::array<std::array<double, D + 1>, D + 1>;
    const Corners<D> old = Relative(from.corners);
    ByFace noise;
    const ClipValues<D> values = ValuesAt(old);
    Clipped<D> clipped(values);
    if (!Cut(old, values, noise, clipped)) return;
    clipped.ForEachSimplex([&](const std::array<std::size_t, D + 1>& corners) {
      Coordinates in_old, in_new;
      Corners<D> positions;
      for (std::size_t i = 0; i <= D; ++i) {
        in_old[i] = clipped.corner(corners[i]).lambda;
        for (std::size_t k = 0; k < D; ++k) positions[i][k] = in_old[i][k + 1];
        for (std::size_t k = 0; k <= D; ++k) {
          in_new[i][k] = clipped.corner(corners[i]).values[k] / scaled_measure_;
        }
      }
      const double measure = from.measure * ScaledMeasure(positions);
      if (measure > 0) visit(in_old, in_new, measure);
    });
  }

 private:
  using ByFace = std::array<double, D + 1>;

  // Clips by all half-spaces; `noise` is that of their values. False if nothing is in common.
  bool Cut(const Corners<D>& old, const ClipValues<D>& values, ByFace& noise,
           Clipped<D>& clipped) const {
    const double extent = std::max(extent_, ExtentOf(old));
    ByFace greatest, least;
    for (std::size_t k = 0; k <= D; ++k) noise[k] = noises_[k] * extent;
    greatest = least = values[0];
    for (std::size_t c = 1; c <= D; ++c) {
      for (std::size_t k = 0; k <= D; ++k) greatest[k] = std::max(greatest[k], values[c][k]);
      for (std::size_t k = 0; k <= D; ++k) least[k] = std::min(least[k], values[c][k]);
    }
    for (std::size_t k = 0; k <= D; ++k) {
      if (!(greatest[k] > noise[k])) return false;
    }
    for (std::size_t k = 0; k <= D; ++k) {
      if (least[k] < -noise[k] && !clipped.By(k, noise[k])) return false;
    }
    return true;
  }

  // The largest rounding error of the new simplex's coordinates at the old one's corners for which
  // linear functions of these stay linear up to rounding. Such coordinates are below 64.
  static constexpr double kFine = 0x1p-43;

  // The values of its half-spaces.
  ClipValues<D> ValuesAt(const Corners<D>& positions) const {
    ClipValues<D> values;
    for (std::size_t c = 0; c <= D; ++c) {
      for (std::size_t k = 0; k <= D; ++k) values[c][k] = -offsets_[k];
      for (std::size_t axis = 0; axis < D; ++axis) {
        for (std::size_t k = 0; k <= D; ++k) values[c][k] += normals_[axis][k] * positions[c][axis];
      }
    }
    return values;
  }

  // The new simplex's coordinates are linear in the old one's, so moments of the latter suffice.
  bool Integrate(const Clipped<D>& clipped, const ClipValues<D>& values, double measure,
                 Mass& mixed, Mass& own) const {
    Mass to_new;  // the new one's coordinates at the corners of the old one
    const double scale = 1 / scaled_measure_;
    for (std::size_t c = 0; c <= D; ++c) {
      for (std::size_t k = 0; k <= D; ++k) to_new[c * (D + 1) + k] = scale * values[c][k];
    }
    const auto at = [&](std::size_t i) -> const auto& { return clipped.corner(i).lambda; };
    const Mass moments = Moments<D + 1>(clipped, measure, at);
    mixed = TransposedTimes(moments, to_new);
    own = TransposedTimes(to_new, mixed);
    return HasAny(moments);
  }

  // For slivers: computes the new simplex's coordinates at each corner's position. Elsewhere they
  // may be large and meaningless.
  bool IntegrateAtPositions(const Clipped<D>& clipped, const Corners<D>& old, double measure,
                            Mass& mixed, Mass& own) const {
    constexpr std::size_t kCorners = D + 1, kBoth = 2 * kCorners;
    const Barycentric<D> coordinates(corners_);
    std::array<std::array<double, kBoth>, Clipped<D>::kMost> both;  // coordinates: old, new
    ForEachBit(clipped.in_use(), [&](std::size_t corner) {
      const auto& lambda = clipped.corner(corner).lambda;
      Vec<D> position{};
      for (std::size_t c = 0; c < kCorners; ++c) {
        for (std::size_t k = 0; k < D; ++k) position[k] += lambda[c] * old[c][k];
      }
      std::copy_n(lambda.begin(), kCorners, both[corner].begin());
      std::copy_n(coordinates(position).begin(), kCorners, both[corner].begin() + kCorners);
    });
    const auto at = [&](std::size_t i) -> const auto& { return both[i]; };
    const auto moments = Moments<kBoth>(clipped, measure, at);
    for (std::size_t a = 0; a < kCorners; ++a) {
      std::copy_n(&moments[a * kBoth + kCorners], kCorners, &mixed[a * kCorners]);
      std::copy_n(&moments[(kCorners + a) * kBoth + kCorners], kCorners, &own[a * kCorners]);
    }
    return HasAny(moments);
  }

  // The product of the transpose of a with b.
  static Mass TransposedTimes(const Mass& a, const Mass& b) {
    constexpr std::size_t kCorners = D + 1;
    Mass product;
    for (std::size_t i = 0; i < kCorners; ++i) {
      std::array<double, kCorners> row{};
      for (std::size_t c = 0; c < kCorners; ++c) {
        const double factor = a[c * kCorners + i];
        for (std::size_t j = 0; j < kCorners; ++j) row[j] += factor * b[c * kCorners + j];
      }
      std::copy_n(row.begin(), kCorners, &product[i * kCorners]);
    }
    return product;
  }

  template <std::size_t N>
  static bool HasAny(const std::array<double, N>& moments) {
    return std::any_of(moments.begin(), moments.end(), [](double m) { return m != 0; });
  }

  Corners<D> Relative(const Corners<D>& corners) const {
    Corners<D> result;
    for (std::size_t k = 0; k <= D; ++k) result[k] = corners[k] - origin_;
    return result;
  }

  // The greatest coordinate in magnitude.
  static double ExtentOf(const Corners<D>& corners) {
    double extent = 0;
    for (const Vec<D>& corner : corners) {
      for (const double c : corner) extent = std::max(extent, std::abs(c));
    }
    return extent;
  }

  Vec<D> origin_;
  Corners<D> corners_;
  // The half-spaces of its faces: normals by axis and face, negated values at the origin, and the
  // rounding error of a value relative to the extent.
  std::array<ByFace, D> normals_;
  ByFace offsets_, noises_;
  double scaled_measure_;
  double extent_;
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_CLIPPER_H_
