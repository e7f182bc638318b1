// Segment work: rule (b) as a fixed point. A subsegment is *encroached* when its open
// diametral ball holds a vertex, or when a tie on the ball's surface keeps it out of
// the Delaunay triangulation; it is then split in the middle.
//
// Encroached once, encroached until split, whatever else is inserted: so the set of
// splits is the least fixed point of a monotone rule, the same in whatever order
// subsegments are looked at. At input angles of 45 degrees and more it is finite.
//
//   s, a, b    subsegment and its ends      m    its midpoint
#ifndef DYNMESH_CORE_MESHING_SEGMENTS_H_
#define DYNMESH_CORE_MESHING_SEGMENTS_H_

#include "core/geometry/constructions.h"
#include "core/meshing/refinement.h"

namespace dynmesh::meshing {

template <template <class> class E>
void Refinement<E>::Check(Context& context) {
  const SubsegmentIndex s = context.item;
  if (context.kind == kRecheck && subsegments_[s].death != sac::kNoStamp &&
      context.Sees(subsegments_[s].death)) {
    return;  // split by now
  }
  bool encroached = FindEncroaching(context, s);
  if (encroached && !CanSplit(subsegments_[s])) {
    encroached = false;
    hit_depth_limit_ = true;
  }
  context.payload().flag = encroached;
  if (encroached) {
    for (const VertexIndex w : witnesses_) {
      context.Read(w);
      SubscribePoint(context, vertices_[w].p);
    }
    SplitInto(context, s);
  } else {
    if (kTraced) SubscribeBox(context, BallOf(subsegments_[s]));
    if (context.kind == kCheck) context.Emit(MakeOutput(Made::kExposure, s));
  }
}

template <template <class> class E>
void Refinement<E>::Split(Context& context) {
  const SubsegmentIndex s = context.item;
  context.payload().flag = true;
  if (subsegments_[s].death != sac::kNoStamp && context.Sees(subsegments_[s].death)) return;
  if (CanSplit(subsegments_[s])) {
    SplitInto(context, s);
  } else {
    hit_depth_limit_ = true;
  }
}

template <template <class> class E>
void Refinement<E>::SplitInto(Context& context, SubsegmentIndex s) {
  const Subsegment sub = subsegments_[s];
  const Point2 m = geometry::Midpoint(vertices_[sub.a].p, vertices_[sub.b].p);
  const VertexIndex v = EmitVertex(context, m, 0, 1, sub.feature);
  const SubsegmentIndex halves[2] = {EmitSubsegment(context, sub.a, v, sub.feature, sub.depth + 1),
                                     EmitSubsegment(context, v, sub.b, sub.feature, sub.depth + 1)};
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
  // Whom does m encroach on? Those not yet exposed will look for themselves.
  FindEncroached(context, m);
  for (std::size_t i = 0; i < encroached_.size(); ++i) {
    const Subsegment& other = subsegments_[encroached_[i]];
    if (encroached_[i] == s || other.a == v || other.b == v) continue;
    context.Request(encroached_strictly_[i] ? kSplit : kRecheck, encroached_[i], next);
  }
  SubscribePoint(context, m);
}

template <template <class> class E>
bool Refinement<E>::CanSplit(const Subsegment& s) const {
  return s.depth < limits_.max_depth &&
         geometry::SquaredDistance(vertices_[s.a].p, vertices_[s.b].p) >
             4 * rules_.least_squared_length();
}

// An output of the previous execution is kept if it is the same thing.
template <template <class> class E>
VertexIndex Refinement<E>::EmitVertex(Context& context, const Point2& p, int ordinal, int dimension,
                                      FeatureSlot feature) {
  for (const sac::Output o : context.old_outputs()) {
    if (WhatOf(o) != Made::kVertex) continue;
    const Vertex& old = vertices_[IndexOf(o)];
    if (old.p == p && old.ordinal == ordinal && old.feature == feature && old.present) {
      context.Emit(o);
      return IndexOf(o);
    }
  }
  const VertexIndex v = NewVertex();
  Vertex& vertex = vertices_[v];
  vertex.p = p;
  vertex.epoch = context.epoch;
  vertex.birth = context.now;
  if constexpr (kTraced) vertex.creator = context.id();
  vertex.feature = feature;
  vertex.dimension = static_cast<std::uint8_t>(dimension);
  vertex.ordinal = static_cast<std::uint8_t>(ordinal);
  context.Emit(MakeOutput(Made::kVertex, v));
  return v;
}

template <template <class> class E>
SubsegmentIndex Refinement<E>::EmitSubsegment(Context& context, VertexIndex a, VertexIndex b,
                                              FeatureSlot feature, int depth) {
  for (const sac::Output o : context.old_outputs()) {
    if (WhatOf(o) != Made::kSubsegment) continue;
    const Subsegment& old = subsegments_[IndexOf(o)];
    if (old.a == a && old.b == b) {
      context.Emit(o);
      return IndexOf(o);
    }
  }
  const SubsegmentIndex s = NewSubsegment();
  Subsegment& sub = subsegments_[s];
  sub.a = a;
  sub.b = b;
  sub.feature = feature;
  sub.depth = static_cast<std::uint8_t>(depth);
  context.Emit(MakeOutput(Made::kSubsegment, s));
  return s;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SEGMENTS_H_
