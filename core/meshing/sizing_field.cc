#include "core/meshing/sizing_field.h"

#include <algorithm>
#include <cmath>

#include "core/base/rounding.h"
#include "core/geometry/constructions.h"

namespace dynmesh::meshing {

template <int D>
double SizingRegion<D>::SquaredDistanceToBox(const geometry::Point<D>& x) const {
  double d2 = 0;
  for (int i = 0; i < D; ++i) {
    const double d = std::max({lo[i] - x[i], x[i] - hi[i], 0.0});
    d2 += d * d;
  }
  return d2;
}

template <int D>
double SizingRegion<D>::DistanceToBox(const geometry::Point<D>& x) const {
  const double d2 = SquaredDistanceToBox(x);
  if (d2 > 0) return std::sqrt(d2) - radius;
  double depth = INFINITY;
  for (int k = 0; k < D; ++k) depth = std::min({depth, x[k] - lo[k], hi[k] - x[k]});
  return -depth - radius;
}

template <int D>
bool SizingRegion<D>::Meets(const geometry::Point<D>& centre, double ball_radius) const {
  const double reach = ball_radius + radius;
  if (SquaredDistanceToBox(centre) > reach * reach) return false;
  return shape == nullptr || shape->Meets(centre, reach);
}

namespace {

// More than coordinates of this magnitude are rounded by in a few operations.
double RoundingAt(double largest) { return 0x1p-44 * largest; }

template <int D>
double LargestCoordinate(const geometry::Point<D>& p) {
  double largest = 0;
  for (int k = 0; k < D; ++k) largest = std::max(largest, std::fabs(p[k]));
  return largest;
}

}  // namespace

template <int D>
bool SizingRegion<D>::Holds(const geometry::Point<D>& centre, double ball_radius,
                            double reach) const {
  // A ball about a point outside of the box between lo and hi (or of the shape) must not reach
  // beyond `within`. If it is larger than that, the box must hold the rest of it.
  const double within = radius * kBarelyNarrower + reach;
  const double wide = ball_radius * kBarelyWider +
                      RoundingAt(std::max({LargestCoordinate<D>(centre), LargestCoordinate<D>(lo),
                                           LargestCoordinate<D>(hi)}));
  if (shape != nullptr) return shape->Holds(centre, wide, within);
  if (wide <= within) return SquaredDistanceToBox(centre) <= (within - wide) * (within - wide);
  const double rest = wide - within;
  for (int k = 0; k < D; ++k) {
    if (!(lo[k] + rest <= centre[k] && centre[k] <= hi[k] - rest)) return false;
  }
  return true;
}

template <int D>
bool SizingRegion<D>::HoldsAround(const Extent<D>& box, double margin) const {
  const geometry::Point<D> low{box.lo}, high{box.hi};
  if (shape != nullptr) {
    return Holds(geometry::Midpoint(low, high),
                 0.5 * std::sqrt(geometry::SquaredDistance(low, high)) + margin, 0);
  }
  const double rounding =
      RoundingAt(std::max({LargestCoordinate<D>(low), LargestCoordinate<D>(high),
                           LargestCoordinate<D>(lo), LargestCoordinate<D>(hi)}));
  const double within = radius * kBarelyNarrower - margin * kBarelyWider;
  const double beyond = rounding + std::max(-within, 0.0);
  double far2 = 0;  // of the corner farthest from the region's box
  for (int k = 0; k < D; ++k) {
    const double d = std::max(box.hi[k] - hi[k], lo[k] - box.lo[k]) + beyond;
    if (d > 0) far2 += d * d;
  }
  return far2 <= (within > 0 ? within * within : 0);
}

template <int D>
bool SizingRegion<D>::MayMeet(const Extent<D>& box) const {
  const geometry::Point<D> low{box.lo}, high{box.hi};
  const double rounding =
      RoundingAt(std::max({LargestCoordinate<D>(low), LargestCoordinate<D>(high),
                           LargestCoordinate<D>(lo), LargestCoordinate<D>(hi)}));
  double d2 = 0;
  for (int k = 0; k < D; ++k) {
    const double d = std::max(box.lo[k] - hi[k], lo[k] - box.hi[k]) - rounding;
    if (d > 0) d2 += d * d;
  }
  if (d2 > radius * radius * kBarelyWider) return false;
  return shape == nullptr ||
         shape->Meets(
             geometry::Midpoint(low, high),
             (0.5 * std::sqrt(geometry::SquaredDistance(low, high)) + radius) * kBarelyWider +
                 rounding);
}

template <int D>
int SizingRegion<D>::LevelOver(const geometry::Point<D>& x, double ball_radius, int below) const {
  using Lattice = AnchorLattice<D>;
  const int own = Lattice::LevelOf(target);
  if (own >= below) return below;
  if (ball_radius == 0) return LevelNear(x, 0, below);
  int level = own;
  const double d2 = SquaredDistanceToBox(x);
  const double distance = d2 > 0 ? std::sqrt(d2) + ball_radius - radius : 0;
  if (distance > 0) {
    const int octaves = (Lattice::LeastLevelAt(distance) - own) / Lattice::kOctave;
    level += std::max(octaves, 0) * Lattice::kOctave;
  }
  for (; level < below; level += Lattice::kOctave) {
    if (Holds(x, ball_radius, Lattice::Reach(own, level))) return level;
  }
  return below;
}

template <int D>
int SizingRegion<D>::LevelNear(const geometry::Point<D>& x, double margin, int below) const {
  using Lattice = AnchorLattice<D>;
  // Nothing finer than `below` reaches farther.
  const double far = Lattice::MostReach(below) + margin + radius;
  const double d2 = SquaredDistanceToBox(x);
  if (!(far >= 0) || d2 > far * far * kBarelyWider) return below;
  const int own = Lattice::LevelOf(target);
  const double distance = std::sqrt(d2) - radius - margin;
  int level = own;
  if (distance > 0) {
    const int octaves = (Lattice::LeastLevelAt(distance) - own) / Lattice::kOctave;
    level += std::max(octaves, 0) * Lattice::kOctave;
  }
  for (; level < below; level += Lattice::kOctave) {
    const double reach = Lattice::Reach(own, level) + margin;
    if (reach >= 0 && Meets(x, reach)) return level;
  }
  return below;
}

template struct SizingRegion<2>;
template struct SizingRegion<3>;

}  // namespace dynmesh::meshing
