// Where a subsegment is split, and whether it may be.
#ifndef DYNMESH_CORE_MESHING_SPLITS_H_
#define DYNMESH_CORE_MESHING_SPLITS_H_

#include <array>
#include <utility>

#include "core/geometry/constructions.h"
#include "core/meshing/complex.h"
#include "core/meshing/refinement_terms.h"

namespace dynmesh::meshing {

// False if s is unsplit, or if the parts would be finer than limits allow.
template <int D, template <class> class E>
bool CanSplit(const Complex<D, E>& complex, const Subsegment<D>& s) {
  return !IsUnsplit(s) &&
         (s.depth < complex.limits.max_depth || !IsOn(RefinementTerm::kDepthEnds)) &&
         complex.SquaredLength(s) > 4 * complex.rules.least_squared_length();
}

// True if s is too short to be split for a gap in `bucket` (the guard of rules.h).
template <int D, template <class> class E>
bool IsGuarded(const Complex<D, E>& complex, const Subsegment<D>& s, int bucket) {
  return RulesOf<D>::IsGuarded(complex.SquaredLength(s), bucket);
}

// The point at which s is split, and the rules of its parts.
template <int D, template <class> class E>
std::pair<geometry::Point<D>, std::array<SplitRule, 2>> SplitOf(const Complex<D, E>& complex,
                                                                const Subsegment<D>& s) {
  if (s.split_rule.kind != SplitRule::Kind::kHalve) {
    const auto &a = complex.vertex(s.whole_a).p, &b = complex.vertex(s.whole_b).p;
    const bool from_b = s.split_rule.from_b;
    const auto &apex = from_b ? b : a, &other = from_b ? a : b;
    const double length = LengthOf(a, b);
    double at = SplitDistance(s.split_rule);
    if (s.split_rule.kind == SplitRule::Kind::kShells)
      at += SkewOf(s.split_rule, apex, other, length);
    return {PointAt(apex, other, length, at), RulesOfParts(s.split_rule, length)};
  }
  return {geometry::Midpoint(complex.vertex(s.a).p, complex.vertex(s.b).p), {}};
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SPLITS_H_
