// Rule (b) for segments as a fixed point. A subsegment is *encroached* if its open diametral ball
// holds a vertex, or if a tie on the ball's surface keeps it out of the Delaunay triangulation.
// Then it is split: in the middle, or where its split rule says (SplitOf).
//
// Once encroached, a subsegment stays so until it is split, whatever else is inserted. So the set
// of splits is the least fixed point of a monotone rule, and does not depend on the order in which
// subsegments are checked. It is finite: subsegments that meet at a small angle are split on
// shells (shells.h).
#ifndef DYNMESH_CORE_MESHING_SEGMENTS_H_
#define DYNMESH_CORE_MESHING_SEGMENTS_H_

#include "core/meshing/complex.h"
#include "core/meshing/emitter.h"
#include "core/meshing/encroachment.h"
#include "core/meshing/refinement_terms.h"
#include "core/meshing/splits.h"

namespace dynmesh::meshing {

// The procedures kCheck, kRecheck and kSplit.
template <int D, template <class> class E>
class SegmentWork {
 public:
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;

  SegmentWork(const Complex<D, E>& complex, Emitter<D, E>& emitter)
      : complex_(complex), emitter_(emitter), search_(complex) {}
  void Run(Context& context) { context.kind == kSplit ? Split(context) : Check(context); }

 private:
  void Check(Context& context);
  void Split(Context& context);
  void SplitInto(Context& context, SubsegmentIndex s);

  const Complex<D, E>& complex_;
  Emitter<D, E>& emitter_;
  EncroachmentSearch<D, E> search_;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
void SegmentWork<D, E>::Check(Context& context) {
  const SubsegmentIndex s = context.item;
  if (context.kind == kRecheck && complex_.subsegment(s).death != sac::kNoStamp &&
      context.Sees(complex_.subsegment(s).death)) {
    context.payload().flag = false;  // a former execution may have split it
    return;
  }
  auto witnesses = search_.WitnessesOf(context, s);
  if (witnesses && !CanSplit(complex_, complex_.subsegment(s))) {
    witnesses.reset();
    emitter_.NoteDepthLimit();
  }
  context.payload().flag = witnesses.has_value();
  if (witnesses) {
    for (const VertexIndex w : *witnesses) {
      context.Read(w);
      complex_.Subscribe(context, {complex_.vertex(w).p.c, complex_.vertex(w).p.c});
    }
    SplitInto(context, s);
  } else {
    if (kTraced) complex_.Subscribe(context, complex_.BallOf(complex_.subsegment(s)));
    if (context.kind == kCheck) context.Emit(MakeOutput(Made::kExposure, s));
  }
}

template <int D, template <class> class E>
void SegmentWork<D, E>::Split(Context& context) {
  const SubsegmentIndex s = context.item;
  context.payload().flag = true;
  if (complex_.subsegment(s).death != sac::kNoStamp && context.Sees(complex_.subsegment(s).death))
    return;
  if (CanSplit(complex_, complex_.subsegment(s))) {
    SplitInto(context, s);
  } else {
    emitter_.NoteDepthLimit();
  }
}

template <int D, template <class> class E>
void SegmentWork<D, E>::SplitInto(Context& context, SubsegmentIndex s) {
  const auto [v, halves] = emitter_.EmitHalves(context, s);
  const Point p = complex_.vertex(v).p;
  context.Emit(MakeOutput(Made::kDeath, s));

  const int bucket = BucketOfEpoch(context.epoch);
  const std::uint64_t round = RoundOfEpoch(context.epoch);
  const sac::Epoch next = MakeEpoch(bucket, round, StepOfEpoch(context.epoch) + 1);
  for (const SubsegmentIndex half : halves) context.Request(kCheck, half, next);
  if (bucket == 0) {
    context.Request(kNearest, v, NearestEpoch());
  } else {
    context.Request(kComplete, v, MakeEpoch(bucket, round, kQualityStep));
  }
  // Subsegments that v encroaches on. Those not yet exposed will check for themselves.
  for (const auto& [other, strictly] : search_.EncroachedBy(context, p)) {
    const Subsegment<D>& sub = complex_.subsegment(other);
    if (other == s || sub.a == v || sub.b == v || !IsOn(RefinementTerm::kCascades)) continue;
    context.Request(strictly ? kSplit : kRecheck, other, next);
  }
  complex_.Subscribe(context, {p.c, p.c});
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SEGMENTS_H_
