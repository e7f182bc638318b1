// How a subsegment is split, and how procedures emit the elements that they make.
#ifndef DYNMESH_CORE_MESHING_SPLITS_H_
#define DYNMESH_CORE_MESHING_SPLITS_H_

#include <array>
#include <utility>

#include "core/geometry/constructions.h"
#include "core/meshing/complex.h"
#include "core/meshing/refinement_terms.h"

namespace dynmesh::meshing {

// False if the parts would be finer than limits allow.
template <int D, template <class> class E>
bool CanSplit(const Complex<D, E>& complex, const Subsegment<D>& s) {
  return (s.depth < complex.limits.max_depth || !Counts(RefinementTerm::kDepthEnds)) &&
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
    const double length = LengthOf(a, b), at = SplitDistance(s.split_rule);
    return {s.split_rule.from_b ? PointAt(b, a, length, at) : PointAt(a, b, length, at),
            RulesOfParts(s.split_rule, length)};
  }
  return {geometry::Midpoint(complex.vertex(s.a).p, complex.vertex(s.b).p), {}};
}

// Emits a vertex at p: that of the previous execution if it is equal, else a new one. `ordinal`:
// which of the operation's vertices; `dimension`: the containing dimension; `feature`: what it lies
// on.
template <int D, template <class> class E>
VertexIndex EmitVertex(Complex<D, E>& complex, ContextOf<D, E>& context,
                       const geometry::Point<D>& p, int ordinal, int dimension, FeatureSlot feature,
                       const Origin& origin = {}) {
  for (const sac::Output o : context.old_outputs()) {
    if (WhatOf(o) != Made::kVertex) continue;
    const Vertex<D>& old = complex.vertex(IndexOf(o));
    if (old.p == p && old.ordinal == ordinal && old.feature == feature &&
        complex.elements.origin(IndexOf(o)) == origin && old.present) {
      context.Emit(o);
      return IndexOf(o);
    }
  }
  const VertexIndex v = complex.elements.NewVertex();
  Vertex<D>& vertex = complex.vertex(v);
  vertex.p = p;
  vertex.epoch = context.epoch;
  vertex.birth = context.now;
  if constexpr (kIsTraced<D, E>) {
    vertex.creator = context.id();
  } else {
    vertex.creator = context.item;
  }
  vertex.feature = feature;
  if (origin.axis != kNoAxis) complex.elements.SetOrigin(v, origin);
  vertex.dimension = static_cast<std::uint8_t>(dimension);
  vertex.ordinal = static_cast<std::uint8_t>(ordinal);
  context.Emit(MakeOutput(Made::kVertex, v));
  return v;
}

// The same for a subsegment.
template <int D, template <class> class E>
SubsegmentIndex EmitSubsegment(Complex<D, E>& complex, ContextOf<D, E>& context,
                               const Subsegment<D>& subsegment) {
  for (const sac::Output o : context.old_outputs()) {
    if (WhatOf(o) != Made::kSubsegment) continue;
    const Subsegment<D>& old = complex.subsegment(IndexOf(o));
    if (old.a == subsegment.a && old.b == subsegment.b) {
      context.Emit(o);
      return IndexOf(o);
    }
  }
  const SubsegmentIndex s = complex.elements.NewSubsegment();
  complex.subsegment(s) = subsegment;
  context.Emit(MakeOutput(Made::kSubsegment, s));
  return s;
}

// Emits the vertex at which s is split, and the two parts.
template <int D, template <class> class E>
std::pair<VertexIndex, std::array<SubsegmentIndex, 2>> EmitHalves(Complex<D, E>& complex,
                                                                  ContextOf<D, E>& context,
                                                                  SubsegmentIndex s) {
  const Subsegment<D> whole = complex.subsegment(s);
  const auto [p, rules] = SplitOf(complex, whole);
  const VertexIndex v = EmitVertex(complex, context, p, 0, 1, whole.feature);
  std::array<SubsegmentIndex, 2> halves;
  for (int i = 0; i < 2; ++i) {
    Subsegment<D> half;
    half.a = i == 0 ? whole.a : v;
    half.b = i == 0 ? v : whole.b;
    half.whole_a = whole.whole_a;
    half.whole_b = whole.whole_b;
    half.feature = whole.feature;
    half.split_rule = rules[i];
    half.depth = whole.depth + 1;
    halves[i] = EmitSubsegment(complex, context, half);
  }
  return {v, halves};
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SPLITS_H_
