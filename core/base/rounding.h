// How coordinates are rounded, and the slack that the quality test has for it. Shared by the mesher
// (meshing/rules.h) and the measure of its result (dynmesh/quality.h). Pure, O(1).
#ifndef DYNMESH_CORE_BASE_ROUNDING_H_
#define DYNMESH_CORE_BASE_ROUNDING_H_

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dynmesh/options.h"

namespace dynmesh {

inline double LargestMagnitude(const Box& box, int dimension) {
  double m = 0;
  for (int i = 0; i < dimension; ++i) m = std::max({m, std::abs(box.lo[i]), std::abs(box.hi[i])});
  return m;
}

// The spacing of doubles at a magnitude. REQUIRES: it is positive and finite.
inline double UlpOf(double magnitude) { return std::ldexp(1.0, std::ilogb(magnitude) - 52); }
// At the largest coordinate of a box.
inline double UlpOf(const Box& box, int dimension) {
  return UlpOf(LargestMagnitude(box, dimension));
}

// The distance below which a mesh refuses two features as too close: 2^10 ulps of the domain's
// largest coordinate, a power of two (2^-41 in the unit square).
inline double LeastDistance(const MeshOptions& options) {
  return 0x1p10 * UlpOf(DomainBox(options), options.dimension);
}

// The relative slack h of the quality test for edges of length e, 2^k <= e^2 < 2^(k+1):
// 2e-9 + 8 u / sqrt(2^k). u is the ulp of the largest coordinate. A coordinate is rounded by u/2,
// and R/e changes by at most (1/2 + small) |dx| / e. The factor 8 leaves room for the roundings of
// constructions. From k, not from e: the last bit of e does not matter, and e^2 may underflow.
inline double QualitySlackAt(int k, double u) {
  return 2e-9 + 8 * u / std::ldexp(k & 1 ? std::numbers::sqrt2 : 1.0, k >> 1);
}

// Factors for a distance or its square, so that a test errs to the safe side. Sums, products and
// roots of a rule change a result relatively by 1e-14 at most. So 1e-9 covers what is computed, and
// 1e-6 covers a value kept in a float, too (2^-24 = 6e-8).
inline constexpr double kWider = 1 + 1e-6, kNarrower = 1 - 1e-6;
inline constexpr double kBarelyWider = 1 + 1e-9, kBarelyNarrower = 1 - 1e-9;
// For the roundings of one root and a product.
inline constexpr double kRootWider = 1 + 1e-15;

// The distance of a cube's corner from its centre, in halves of its side; rounded up.
template <int D>
inline constexpr double kCornerOfCube = D == 2 ? 1.41422 : 1.7321;

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_ROUNDING_H_
