// The lattices of anchors (anchors.h), the vertices of areas with a target length and of their
// surroundings: triangular in 2D, body-centred cubic in 3D. A lattice is a function of its *level*
// alone; an octave of spacing has eight levels. So regions of nearly the same target share a
// lattice, wherever they lie and move.
//
// Spacings s keep circumradii within target / sqrt 2 (sizing_field.h): s / sqrt 3 for triangles, s
// sqrt 5 / 4 for the tetrahedra of a cube of side s. Angles are 60 degrees; dihedral angles 60 and
// 90.
//
// Lattices that differ by whole octaves are *nested*: the finer one contains the wider one. So
// sizes grow from a region outwards without a seam, octave by octave. Pure; thread-safe.
#ifndef DYNMESH_CORE_MESHING_ANCHOR_LATTICE_H_
#define DYNMESH_CORE_MESHING_ANCHOR_LATTICE_H_

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/base/rounding.h"
#include "core/geometry/point.h"
#include "core/meshing/spatial_tree.h"

namespace dynmesh::meshing {

template <int D>
class AnchorLattice {
 public:
  using Point = geometry::Point<D>;
  // In half spacings along each axis (in 2D in rows along the second): all even or all odd.
  using Index = std::array<std::int64_t, D>;

  // The level of the widest lattice that is fine enough for a target > 0.
  static int LevelOf(double target) { return LevelWithin(kMostSpacing * target); }

  static double Spacing(int level) {
    return std::ldexp(kStep[level & (kSteps - 1)], level >> kStepBits);
  }
  static constexpr int kOctave = 8;
  static bool AreNested(int level, int other) { return ((level ^ other) & (kSteps - 1)) == 0; }

  // How far the lattice of `level` extends from a region of level `own`. `level`: own, or wider and
  // nested.
  static double Reach(int own, int level) {
    return (level == own ? kOwnReach : kWiderReach) * Spacing(level);
  }
  // An upper bound for finer levels: no lattice finer than `level` extends as far.
  static double MostReach(int level) { return kWiderReach * Spacing(level); }
  // A region with this target or more has no lattice finer than `level`.
  static double MostTarget(int level) { return Spacing(level) / kMostSpacing * kBarelyWider; }
  // No lattice of a finer level extends as far as `distance` > 0.
  static int LeastLevelAt(double distance) {
    return LevelWithin(distance / kWiderReach * kBarelyNarrower);
  }

  // A point, identified by the widest level that contains it.
  struct Node {
    int level;
    Index index;

    friend bool operator==(const Node&, const Node&) = default;
    template <class H>
    friend H AbslHashValue(H h, const Node& node) {
      return H::combine(std::move(h), node.level, node.index);
    }
  };
  static Node NodeOf(int level, Index index) {
    while (level < kWidest && IsOfWider(index)) {
      for (std::int64_t& i : index) i /= 2;
      level += kOctave;
    }
    return {level, index};
  }

  explicit AnchorLattice(int level) : spacing_(Spacing(level)) {}

  double spacing() const { return spacing_; }
  Point At(const Index& index) const {
    Point p;
    for (int k = 0; k < D; ++k) p[k] = static_cast<double>(index[k]) * StepAlong(k);
    return p;
  }

  // Calls f(index, point) for the points in the box until f returns false. Returns false if it did.
  // Skips balls for which may_matter(centre, radius) is false.
  template <class MayMatter, class F>
  bool ForEachIn(const Extent<D>& box, MayMatter may_matter, F f) const {
    Index lo, hi;
    for (int k = 0; k < D; ++k) {
      if (!(box.lo[k] <= box.hi[k])) return true;
      lo[k] = static_cast<std::int64_t>(std::ceil(box.lo[k] / StepAlong(k)));
      hi[k] = static_cast<std::int64_t>(std::floor(box.hi[k] / StepAlong(k)));
    }
    return ForEachBetween(lo, hi, may_matter, f);
  }

 private:
  static constexpr int kStepBits = 3, kSteps = 1 << kStepBits;
  static constexpr double kStep[kSteps] = {1,
                                           1.0905077326652577,
                                           1.189207115002721,
                                           1.2968395546510096,
                                           1.4142135623730951,
                                           1.5422108254079407,
                                           1.6817928305074290,
                                           1.8340080864093424};
  static constexpr double kMostSpacing = D == 2 ? 1.22 : 1.26;
  // kOwnReach: what a ball that meets the region and is not too large extends beyond it, or a
  // little less. In 2D a row of balls behind a row at 1.0 may miss the region by a hair: then a
  // point that makes one of them meet the region makes the next one do so, all along the border.
  // kWiderReach: where one octave follows another, all simplices have R / e <= sqrt 2 in 2D, 1.4 in
  // 3D. With 1.25 there are 4 % fewer vertices, but an edit changes twice as many.
  static constexpr double kOwnReach = D == 2 ? 1.05 : 1.0, kWiderReach = 1.5;
  static constexpr int kWidest = 1000 * kSteps;  // the origin belongs to all levels

  // The widest level with a spacing of at most `spacing`.
  static int LevelWithin(double spacing) {
    constexpr int kMantissaBits = 52, kBias = 1023;
    const auto bits = std::bit_cast<std::uint64_t>(spacing);
    const int exponent = static_cast<int>(bits >> kMantissaBits);
    if (exponent == 0) return LevelWithin(spacing * 0x1p64) - 64 * kSteps;
    const double mantissa = std::bit_cast<double>(
        (bits & ((std::uint64_t{1} << kMantissaBits) - 1)) | std::uint64_t{kBias} << kMantissaBits);
    int step = kSteps - 1;
    while (kStep[step] > mantissa) --step;
    return kSteps * (exponent - kBias) + step;
  }
  static bool IsOfWider(const Index& index) {
    for (int k = 0; k < D; ++k) {
      if ((index[k] & 1) != 0 || ((index[k] ^ index[0]) & 2) != 0) return false;
    }
    return true;
  }
  double StepAlong(int axis) const {
    return D == 2 && axis == 1 ? spacing_ * 0.86602540378443865 : spacing_ / 2;
  }
  template <class MayMatter, class F>
  bool ForEachBetween(const Index& lo, const Index& hi, MayMatter& may_matter, F& f) const;

  double spacing_;
};

template <int D>
template <class MayMatter, class F>
bool AnchorLattice<D>::ForEachBetween(const Index& lo, const Index& hi, MayMatter& may_matter,
                                      F& f) const {
  constexpr std::int64_t kFew = 4;  // along an axis
  int widest = 0;
  for (int k = 0; k < D; ++k) {
    if (lo[k] > hi[k]) return true;
    if (hi[k] - lo[k] > hi[widest] - lo[widest]) widest = k;
  }
  const Point at_lo = At(lo), at_hi = At(hi);
  Point centre;
  double radius2 = 0;
  for (int k = 0; k < D; ++k) {
    centre[k] = 0.5 * (at_lo[k] + at_hi[k]);
    radius2 += 0.25 * (at_hi[k] - at_lo[k]) * (at_hi[k] - at_lo[k]);
  }
  if (!may_matter(centre, std::sqrt(radius2) * kBarelyWider + 1e-6 * spacing_)) return true;
  if (hi[widest] - lo[widest] >= kFew) {
    const std::int64_t middle = lo[widest] + (hi[widest] - lo[widest]) / 2;
    Index up_to = hi, from = lo;
    up_to[widest] = middle;
    from[widest] = middle + 1;
    return ForEachBetween(lo, up_to, may_matter, f) && ForEachBetween(from, hi, may_matter, f);
  }
  for (Index index = lo;;) {
    bool is_point = true;
    for (int k = 1; k < D; ++k) is_point = is_point && ((index[k] ^ index[0]) & 1) == 0;
    if (is_point && !f(index, At(index))) return false;
    int k = 0;
    while (k < D && index[k] == hi[k]) index[k] = lo[k], ++k;
    if (k == D) return true;
    ++index[k];
  }
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_ANCHOR_LATTICE_H_
