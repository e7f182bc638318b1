// The order of operations within an epoch: a function of what their items are.
#ifndef DYNMESH_CORE_MESHING_ORDER_H_
#define DYNMESH_CORE_MESHING_ORDER_H_

#include <array>
#include <cstdint>

#include "core/meshing/complex.h"
#include "core/meshing/refinement_terms.h"

namespace dynmesh::meshing {

// Uniform.
template <int D, template <class> class E>
std::uint64_t Priority(const Complex<D, E>& complex, sac::Kind kind, sac::Item item) {
  if (!IsOn(RefinementTerm::kOrderByHash)) return item;
  if (kind <= kComplete) return geometry::HashOf(complex.vertex(item).p);
  if (kind == kCure) return complex.slivers[item].hash;
  return Mix(complex.HashOf(complex.subsegment(item)) + kind);
}

// Of operations with one priority.
template <int D, template <class> class E>
bool Before(const Complex<D, E>& complex, sac::Kind kind_a, sac::Item a, sac::Kind kind_b,
            sac::Item b) {
  const auto position = [&](VertexIndex v) -> const geometry::Point<D>& {
    return complex.vertex(v).p;
  };
  if (kind_a != kind_b) return kind_a < kind_b;
  if (kind_a <= kComplete) return position(a) < position(b);
  if (kind_a == kCure) {
    const auto corners = [&](sac::Item item) {
      std::array<geometry::Point<D>, 4> p;
      for (std::size_t i = 0; i < 4; ++i) p[i] = position(complex.slivers[item].v[i]);
      return p;
    };
    return corners(a) < corners(b);
  }
  const Subsegment<D>&s = complex.subsegment(a), &t = complex.subsegment(b);
  if (position(s.a) != position(t.a)) return position(s.a) < position(t.a);
  return position(s.b) < position(t.b);
}

// The epoch at which x does the work of bucket `own`, requested by v's Complete at epoch `now`.
// That bucket, if it is later than now's. Else now's bucket: in this round if x follows v in it,
// else in the next round.
template <int D, template <class> class E>
sac::Epoch NoEarlierThan(const Complex<D, E>& complex, sac::Epoch now, VertexIndex v, VertexIndex x,
                         int own) {
  const int bucket = BucketOfEpoch(now);
  if (own > bucket) return MakeEpoch(own, 0, kQualityStep);
  const std::uint64_t of_v = Priority(complex, kComplete, v),
                      of_x = Priority(complex, kComplete, x);
  const bool later = of_v != of_x ? of_v < of_x : Before(complex, kComplete, v, kComplete, x);
  return later ? now : MakeEpoch(bucket, RoundOfEpoch(now) + 1, kQualityStep);
}

// Requests x's Complete for that epoch, from the Complete that runs.
template <int D, template <class> class E>
void RequestNoEarlierThanNow(const Complex<D, E>& complex, ContextOf<D, E>& context, VertexIndex x,
                             int own) {
  context.Request(kComplete, x, NoEarlierThan(complex, context.epoch, context.item, x, own));
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_ORDER_H_
