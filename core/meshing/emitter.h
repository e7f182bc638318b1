// What operations make: new elements, which nothing sees before they are published (publisher.h).
#ifndef DYNMESH_CORE_MESHING_EMITTER_H_
#define DYNMESH_CORE_MESHING_EMITTER_H_

#include <array>
#include <utility>

#include "core/meshing/complex.h"
#include "core/meshing/splits.h"

namespace dynmesh::meshing {

// All that an operation may change of the complex, which it sees const. Thread-compatible.
template <int D, template <class> class E>
class Emitter {
 public:
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;

  explicit Emitter(Complex<D, E>& complex) : complex_(complex) {}

  // Emits a vertex at p: that of the previous execution if it is equal, else a new one. `ordinal`:
  // which of the operation's vertices; `dimension`: the containing dimension; `feature`: what it
  // lies on.
  VertexIndex EmitVertex(Context& context, const Point& p, int ordinal, int dimension,
                         FeatureSlot feature, const Origin& origin = {});
  // The same for a subsegment.
  SubsegmentIndex EmitSubsegment(Context& context, const Subsegment<D>& subsegment);
  // Emits the vertex at which s is split, and the two parts.
  std::pair<VertexIndex, std::array<SubsegmentIndex, 2>> EmitHalves(Context& context,
                                                                    SubsegmentIndex s);
  // An insertion or a split is refused because it would be finer than limits allow.
  void NoteDepthLimit() { complex_.run.NoteDepthLimit(); }

 private:
  Complex<D, E>& complex_;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
VertexIndex Emitter<D, E>::EmitVertex(Context& context, const Point& p, int ordinal, int dimension,
                                      FeatureSlot feature, const Origin& origin) {
  for (const sac::Output o : context.old_outputs()) {
    if (WhatOf(o) != Made::kVertex) continue;
    const Vertex<D>& old = complex_.vertex(IndexOf(o));
    if (old.p == p && old.ordinal == ordinal && old.feature == feature &&
        complex_.elements.origin(IndexOf(o)) == origin && old.present) {
      context.Emit(o);
      return IndexOf(o);
    }
  }
  const VertexIndex v = complex_.elements.NewVertex();
  Vertex<D>& vertex = complex_.vertex(v);
  vertex.p = p;
  vertex.epoch = context.epoch;
  vertex.birth = context.now;
  if constexpr (kIsTraced<D, E>) {
    vertex.creator = context.id();
  } else {
    vertex.creator = context.item;
  }
  vertex.feature = feature;
  if (origin.axis != kNoAxis) complex_.elements.SetOrigin(v, origin);
  vertex.dimension = static_cast<std::uint8_t>(dimension);
  vertex.ordinal = static_cast<std::uint8_t>(ordinal);
  context.Emit(MakeOutput(Made::kVertex, v));
  return v;
}

template <int D, template <class> class E>
SubsegmentIndex Emitter<D, E>::EmitSubsegment(Context& context, const Subsegment<D>& subsegment) {
  for (const sac::Output o : context.old_outputs()) {
    if (WhatOf(o) != Made::kSubsegment) continue;
    const Subsegment<D>& old = complex_.subsegment(IndexOf(o));
    if (old.a == subsegment.a && old.b == subsegment.b) {
      context.Emit(o);
      return IndexOf(o);
    }
  }
  const SubsegmentIndex s = complex_.elements.NewSubsegment();
  complex_.subsegment(s) = subsegment;
  context.Emit(MakeOutput(Made::kSubsegment, s));
  return s;
}

template <int D, template <class> class E>
std::pair<VertexIndex, std::array<SubsegmentIndex, 2>> Emitter<D, E>::EmitHalves(
    Context& context, SubsegmentIndex s) {
  const Subsegment<D> whole = complex_.subsegment(s);
  const auto [p, rules] = SplitOf(complex_, whole);
  const VertexIndex v = EmitVertex(context, p, 0, 1, whole.feature);
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
    halves[i] = EmitSubsegment(context, half);
  }
  return {v, halves};
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_EMITTER_H_
