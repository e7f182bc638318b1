// Segment work: first splits because of features alone (Presplit), then rule (b) as a fixed point.
//
// Presplit. A piece of a segment is split if a feature disjoint from the segment is too near:
//   a point or segment that meets the open ball about the piece's middle, or is nearer to the piece
//   than an eighth of its length;
//   a facet at squared distance < FacetReach2 from the piece's middle.
// This is Disencroach (Fig. 5.5) by features instead of by the cells of BuildQT: remaining pieces
// are no longer than 8 times the local feature size. Features far away have no influence on a
// segment, so an edit changes only the pieces near it. No ball of a piece holds a vertex of a
// disjoint feature, so splits of one segment do not cause splits of others.
//
// Rule (b). A subsegment is *encroached* if its open diametral ball holds a vertex, or if a tie on
// the ball's surface keeps it out of the Delaunay triangulation. Then it is split: in the middle,
// or where its piece says (SplitOf).
//
// Once encroached, a subsegment stays so until it is split, whatever else is inserted. So the set
// of splits is the least fixed point of a monotone rule, and does not depend on the order in which
// subsegments are checked. It is finite: pieces of segments that meet at a small angle are split on
// shells (shells.h).
#ifndef DYNMESH_CORE_MESHING_SEGMENTS_H_
#define DYNMESH_CORE_MESHING_SEGMENTS_H_

#include <array>
#include <optional>
#include <utility>

#include "core/geometry/angles.h"
#include "core/geometry/constructions.h"
#include "core/geometry/segment_distance.h"
#include "core/meshing/refinement.h"

namespace dynmesh::meshing {

template <int D, template <class> class E>
void Refinement<D, E>::Presplit(Context& context) {
  const SubsegmentIndex s = context.item;
  const Subsegment& sub = subsegments_[s];
  double d2 = 0;
  const auto feature = NearestTooNear(sub, &d2);
  const bool facet_is_nearer = IsFacetTooNear(sub, feature.has_value(), &d2),
             is_too_near = feature.has_value() || facet_is_nearer;
  context.payload().flag = is_too_near;
  context.payload().radius2 = is_too_near ? RoundedUp(d2) : 0;
  if constexpr (kTraced) {
    const Point &a = vertices_[sub.a].p, &b = vertices_[sub.b].p;
    const double reach =
        is_too_near ? std::sqrt(d2) : 0.625 * std::sqrt(geometry::SquaredDistance(a, b));
    Extent<D> box = Extent<D>::Nothing();
    box.AddBall(geometry::Midpoint(a, b), reach * (1 + 1e-6) + 2 * rules_.ulp());
    SubscribeBox(context, box);
    if (feature && !facet_is_nearer) context.Read(feature->a), context.Read(feature->b);
  }
  if (!(is_too_near || IsTooLong(sub)) || !CanSplit(sub)) {
    return context.Request(kCheck, s, FirstCheckEpoch());
  }
  const auto [v, halves] = EmitHalves(context, s);
  const sac::Epoch next = PresplitEpoch(subsegments_[halves[0]].depth);
  for (const SubsegmentIndex half : halves) context.Request(kPresplit, half, next);
  context.Request(kNearest, v, NearestEpoch());
}

// True if s is too long for a sizing region that its ball meets. The balls of shorter pieces hold
// no anchor (anchors.h).
template <int D, template <class> class E>
bool Refinement<D, E>::IsTooLong(const Subsegment& s, const SizingRegion<D>& region) const {
  constexpr double kMost = 1.3;  // in targets
  const Point &a = vertices_[s.a].p, &b = vertices_[s.b].p;
  const double length = std::sqrt(geometry::SquaredDistance(a, b));
  return length > kMost * region.target && region.Meets(geometry::Midpoint(a, b), 0.5 * length);
}

template <int D, template <class> class E>
bool Refinement<D, E>::IsTooLong(const Subsegment& s) const {
  if (sizing_.empty()) return false;
  const Point &a = vertices_[s.a].p, &b = vertices_[s.b].p;
  return sizing_.Any(geometry::Midpoint(a, b), 0.5 * std::sqrt(geometry::SquaredDistance(a, b)),
                     [&](const SizingRegion<D>& region) { return IsTooLong(s, region); });
}

// A function of coordinates to the bit. d2: the feature's squared distance from the middle of s.
template <int D, template <class> class E>
bool Refinement<D, E>::IsTooNear(const Subsegment& s, const InputFeature<D>& feature,
                                 double d2) const {
  const Point &a = vertices_[s.a].p, &b = vertices_[s.b].p;
  const double length2 = geometry::SquaredDistance(a, b);
  return 4 * d2 < length2 || 64 * geometry::SquaredDistance(a, b, feature.p, feature.q) < length2;
}

// The feature nearest to the middle of s, of those too near. d2: its squared distance from the
// middle. By packing, one feature is the nearest of only a few pieces of a given length.
template <int D, template <class> class E>
std::optional<InputFeature<D>> Refinement<D, E>::NearestTooNear(const Subsegment& s,
                                                                double* d2) const {
  const Point &a = vertices_[s.a].p, &b = vertices_[s.b].p;
  const Point middle = geometry::Midpoint(a, b);
  const double length = std::sqrt(geometry::SquaredDistance(a, b));
  std::optional<InputFeature<D>> nearest;
  double least2 = 0.391 * length * length;  // (5/8)^2, rounded up
  features_.VisitNear(
      middle, least2, {s.whole_a, s.whole_b},
      [&](const Point& centre, double half) {
        const double reach = half * std::sqrt(double{D}) * (1 + 1e-6) + rules_.ulp();
        const double in_ball = 0.5 * length + reach, near = 0.125 * length + reach;
        return geometry::SquaredDistance(centre, middle) < in_ball * in_ball ||
               geometry::SquaredDistance(centre, a, b) < near * near;
      },
      [&](const InputFeature<D>& f) {
        if (!f.IsDisjoint(s.whole_a, s.whole_b)) return;
        const double f2 = geometry::SquaredDistance(middle, f.p, f.q);
        if (!(f2 < least2) || !IsTooNear(s, f, f2)) return;
        nearest = f;
        least2 = f2;
      });
  *d2 = least2;
  return nearest;
}

// A facet farther than this from the middle leaves s whole, though it may meet the ball of s: a
// vertex in the ball is then an anchor of the facet. Using the whole ball, 125 boxes have 4 % more
// vertices.
template <int D, template <class> class E>
double Refinement<D, E>::FacetReach2(const Subsegment& s) const {
  return 0.125 * geometry::SquaredDistance(vertices_[s.a].p, vertices_[s.b].p);
}

// True if the inside of a disjoint facet is nearer to the middle of s than FacetReach2 and, if
// is_near, than *d2. Then *d2 becomes its squared distance. (The facet's edges are features of
// their own.)
template <int D, template <class> class E>
bool Refinement<D, E>::IsFacetTooNear(const Subsegment& s, bool is_near, double* d2) const {
  bool found = false;
  if constexpr (D == 3) {
    if (facets_.empty()) return false;
    const Point middle = geometry::Midpoint(vertices_[s.a].p, vertices_[s.b].p);
    double least2 = FacetReach2(s);
    if (is_near) least2 = std::min(least2, *d2);
    facets_.ForEachNear(middle, std::sqrt(least2), [&](const Facet& facet) {
      if (facet.HasCorner(s.whole_a) || facet.HasCorner(s.whole_b)) return;
      const double h = facet.plane().Height(middle), h2 = h * h;
      if (!(h2 < least2) || !facet.IsInside(facet.plane().Foot(middle))) return;
      least2 = h2;
      found = true;
    });
    if (found) *d2 = least2;
  }
  return found;
}

template <int D, template <class> class E>
void Refinement<D, E>::Check(Context& context) {
  const SubsegmentIndex s = context.item;
  if (context.kind == kRecheck && subsegments_[s].death != sac::kNoStamp &&
      context.Sees(subsegments_[s].death)) {
    return;  // split in the meantime
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

template <int D, template <class> class E>
void Refinement<D, E>::Split(Context& context) {
  const SubsegmentIndex s = context.item;
  context.payload().flag = true;
  if (subsegments_[s].death != sac::kNoStamp && context.Sees(subsegments_[s].death)) return;
  if (CanSplit(subsegments_[s])) {
    SplitInto(context, s);
  } else {
    hit_depth_limit_ = true;
  }
}

// Emits the vertex at which s is split, and the two parts.
template <int D, template <class> class E>
std::pair<VertexIndex, std::array<SubsegmentIndex, 2>> Refinement<D, E>::EmitHalves(
    Context& context, SubsegmentIndex s) {
  const Subsegment sub = subsegments_[s];
  const auto [p, pieces] = SplitOf(sub);
  const VertexIndex v = EmitVertex(context, p, 0, 1, sub.feature);
  std::array<SubsegmentIndex, 2> halves;
  for (int i = 0; i < 2; ++i) {
    Subsegment half;
    half.a = i == 0 ? sub.a : v;
    half.b = i == 0 ? v : sub.b;
    half.whole_a = sub.whole_a;
    half.whole_b = sub.whole_b;
    half.feature = sub.feature;
    half.piece = pieces[i];
    half.depth = sub.depth + 1;
    halves[i] = EmitSubsegment(context, half);
  }
  return {v, halves};
}

template <int D, template <class> class E>
void Refinement<D, E>::SplitInto(Context& context, SubsegmentIndex s) {
  const auto [v, halves] = EmitHalves(context, s);
  const Point p = vertices_[v].p;
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
  FindEncroached(context, p);
  for (std::size_t i = 0; i < encroached_.size(); ++i) {
    const Subsegment& other = subsegments_[encroached_[i]];
    if (encroached_[i] == s || other.a == v || other.b == v) continue;
    context.Request(encroached_strictly_[i] ? kSplit : kRecheck, encroached_[i], next);
  }
  SubscribePoint(context, p);
}

template <int D, template <class> class E>
bool Refinement<D, E>::CanSplit(const Subsegment& s) const {
  return s.depth < limits_.max_depth &&
         geometry::SquaredDistance(vertices_[s.a].p, vertices_[s.b].p) >
             4 * rules_.least_squared_length();
}

template <int D, template <class> class E>
bool Refinement<D, E>::IsGuarded(const Subsegment& s, int bucket) const {
  return Rules::IsGuarded(geometry::SquaredDistance(vertices_[s.a].p, vertices_[s.b].p), bucket);
}

// Emits the previous execution's output again if it is equal; else makes a new one.
template <int D, template <class> class E>
VertexIndex Refinement<D, E>::EmitVertex(Context& context, const Point& p, int ordinal,
                                         int dimension, FeatureSlot feature) {
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
  if constexpr (kTraced) {
    vertex.creator = context.id();
  } else {
    vertex.creator = context.item;
  }
  vertex.feature = feature;
  vertex.dimension = static_cast<std::uint8_t>(dimension);
  vertex.ordinal = static_cast<std::uint8_t>(ordinal);
  context.Emit(MakeOutput(Made::kVertex, v));
  return v;
}

template <int D, template <class> class E>
SubsegmentIndex Refinement<D, E>::EmitSubsegment(Context& context, const Subsegment& subsegment) {
  for (const sac::Output o : context.old_outputs()) {
    if (WhatOf(o) != Made::kSubsegment) continue;
    const Subsegment& old = subsegments_[IndexOf(o)];
    if (old.a == subsegment.a && old.b == subsegment.b) {
      context.Emit(o);
      return IndexOf(o);
    }
  }
  const SubsegmentIndex s = NewSubsegment();
  subsegments_[s] = subsegment;
  context.Emit(MakeOutput(Made::kSubsegment, s));
  return s;
}

// --- Small angles -----------------------------------------------------------------------

// The point at which s is split, and the rules of its parts.
template <int D, template <class> class E>
std::pair<geometry::Point<D>, std::array<Piece, 2>> Refinement<D, E>::SplitOf(
    const Subsegment& s) const {
  if constexpr (D == 2) {
    if (s.piece.rule != Piece::Rule::kHalve) {
      const Point &a = vertices_[s.whole_a].p, &b = vertices_[s.whole_b].p;
      const double length = LengthOf(a, b), at = SplitDistance(s.piece);
      return {s.piece.from_b ? PointAt(b, a, length, at) : PointAt(a, b, length, at),
              SplitPiece(s.piece, length)};
    }
  }
  return {geometry::Midpoint(vertices_[s.a].p, vertices_[s.b].p), {}};
}

// The subsegment that was split at v. REQUIRES: v has containing dimension 1.
template <int D, template <class> class E>
const Subsegment<D>& Refinement<D, E>::SplitAt(VertexIndex v) const {
  SubsegmentIndex parent = vertices_[v].creator;
  if constexpr (kTraced) parent = engine_.item(parent);
  return subsegments_[parent];
}

// The shell on which v lies, if a split put it there.
template <int D, template <class> class E>
std::optional<typename Refinement<D, E>::Shell> Refinement<D, E>::ShellOf(VertexIndex v) const {
  if (vertices_[v].dimension != 1) return std::nullopt;
  const Subsegment& s = SplitAt(v);
  if (s.piece.rule != Piece::Rule::kShells) return std::nullopt;
  const bool from_b = s.piece.from_b;
  return Shell{from_b ? s.whole_b : s.whole_a, from_b ? s.whole_a : s.whole_b,
               SplitDistance(s.piece)};
}

template <int D, template <class> class E>
bool Refinement<D, E>::IsSeditious(VertexIndex v, VertexIndex u) const {
  if (vertices_[v].dimension != 1 || vertices_[u].dimension != 1) return false;
  if constexpr (D == 2) {
    const auto of_v = ShellOf(v), of_u = ShellOf(u);
    return of_v && of_u && of_v->apex == of_u->apex && of_v->distance == of_u->distance &&
           of_v->other != of_u->other &&
           geometry::IsSmallAngle(vertices_[of_v->apex].p, vertices_[of_v->other].p,
                                  vertices_[of_u->other].p);
  }
  return false;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SEGMENTS_H_
