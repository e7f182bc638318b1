// The lattices whose points are the vertices of areas with a target length: triangular in 2D,
// body-centred cubic in 3D. A lattice is a function of its *level* alone, a spacing of eight to the
// octave, so that regions of nearly the same target share one, wherever they lie and move.
//
// Spacings keep circumradii within target / sqrt 2 (sizing_field.h): triangles have s / sqrt 3,
// tetrahedra of a cube of side s have s sqrt 5 / 4. Angles are 60 degrees; dihedral angles 60 and
// 90. Pure; thread-safe.
#ifndef DYNMESH_CORE_MESHING_ANCHOR_LATTICE_H_
#define DYNMESH_CORE_MESHING_ANCHOR_LATTICE_H_

#include <array>
#include <cmath>
#include <cstdint>

#include "core/geometry/point.h"
#include "core/meshing/spatial_tree.h"

namespace dynmesh::meshing {

template <int D>
class AnchorLattice {
 public:
  using Point = geometry::Point<D>;
  // In half spacings along each axis, in 2D in rows along the second: all even or all odd.
  using Index = std::array<std::int64_t, D>;

  // The level of the widest lattice that is fine enough for a target > 0.
  static int LevelOf(double target) {
    int exponent;
    const double mantissa = 2 * std::frexp(kMostSpacing * target, &exponent);  // 1 to 2
    int step = kSteps - 1;
    while (kStep[step] > mantissa) --step;
    return kSteps * (exponent - 1) + step;
  }

  explicit AnchorLattice(int level)
      : spacing_(std::ldexp(kStep[level & (kSteps - 1)], level >> kStepBits)) {}

  double spacing() const { return spacing_; }
  Point At(const Index& index) const {
    Point p;
    for (int k = 0; k < D; ++k) p[k] = static_cast<double>(index[k]) * StepAlong(k);
    return p;
  }

  // Calls f(index, point) for the points in the box, until f says false. Passes over balls for
  // which may_matter(centre, radius) says no. False if f did.
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
  if (!may_matter(centre, std::sqrt(radius2) * (1 + 1e-9) + 1e-6 * spacing_)) return true;
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
