// Complete (rule a): inserts Steiner points until there is no gap in this bucket or an earlier one.
// Two criteria define a gap:
//
// *By edges* (the default): an edge that v owns has a gap if a corner of its Voronoi edge (3D:
// Voronoi face) is farther than rho times the edge's length. An edge is owned by its younger end:
// the one born in a later epoch or by a later operation; of two ends born together in segment work
// or with the input, the one of greater hash. New edges always have the newborn at an end, and
// Voronoi edges and faces only shrink. So an edge without a gap stays so, and only newborns are
// ever queued.
//
// *The thesis's* (Def. 4.2.3): no corner of v's Voronoi cell is farther than rho NN(v). Every
// vertex deals with its own cell. A newborn queues its neighbours where it may have lowered
// their NN (Fig. 5.6, INSERT).
//
//   v       the vertex          u       a neighbour
#ifndef DYNMESH_CORE_MESHING_COMPLETE_H_
#define DYNMESH_CORE_MESHING_COMPLETE_H_

#include <algorithm>
#include <cassert>

#include "core/geometry/constructions.h"
#include "core/meshing/refinement.h"

namespace dynmesh::meshing {

// ComputeNN. Edges of v have length >= NN(v), so there is no work in earlier buckets.
template <int D, template <class> class E>
void Refinement<D, E>::Nearest(Context& context) {
  const VertexIndex v = context.item;
  const Near nearest = NearestTo(context, v);
  double d2 = nearest.d2;
  if (D == 3 && !facets_.empty()) d2 = FacetDistance2(v, d2);
  context.payload().radius2 = RoundedUp(d2);
  context.Request(kComplete, v, MakeEpoch(BucketOf(d2), 0, kQualityStep));
  if constexpr (kTraced) {
    if (nearest.v != kNil) context.Read(nearest.v);
    Extent<D> box = Extent<D>::Nothing();
    box.AddBall(vertices_[v].p, std::sqrt(d2) * (1 + 1e-9) + 2 * rules_.ulp());
    SubscribeBox(context, box);
  }
}

template <int D, template <class> class E>
void Refinement<D, E>::Complete(Context& context) {
  const VertexIndex v = context.item;
  const int bucket = BucketOfEpoch(context.epoch);
  const std::uint64_t next_round = RoundOfEpoch(context.epoch) + 1;
  FindLink(v);
  if (ReadIdleStar(context, v, rules_.Reach(bucket))) return;
  FindStar(context, v, rules_.Reach(bucket));

  skipped_.clear();
  Candidate gap;
  int ordinal = 0;
  bool yielded = false, kept_out = false;
  // Each point fills its gap, and there is room for only a few. The bound kMostOutputs ends the
  // loop even if a wrong view violates this.
  while (ordinal < kMostOutputs && FindNext(bucket, &gap)) {
    FindEncroached(context, gap.x);
    if (!encroached_.empty()) {
      // Yield: the subsegments are split first, then v runs again. A subsegment that may not be
      // split any more keeps the point out for good.
      const bool is_guarded =
          !gap.required && std::ranges::any_of(encroached_, [&](SubsegmentIndex s) {
            return IsGuarded(subsegments_[s], bucket);
          });
      const bool can = std::ranges::all_of(
          encroached_, [&](SubsegmentIndex s) { return CanSplit(subsegments_[s]); });
      if (is_guarded || !can) {
        skipped_.push_back({gap.neighbour, gap.left});
        if (is_guarded) kept_out = true;
        if (!is_guarded) hit_depth_limit_ = true;
        continue;
      }
      for (const SubsegmentIndex s : encroached_) {
        context.Request(kSplit, s, MakeEpoch(bucket, next_round, 0));
      }
      context.Request(kComplete, v, MakeEpoch(bucket, next_round, kQualityStep));
      yielded = true;
      break;
    }
    if constexpr (D == 2) {
      if (is_global() && by_edge() && ordinal == 0) {
        gap_triangle_ = corners_[gap.corner].simplex;
        PrefetchBeyond(gap.corner);
      }
    }
    const VertexIndex x =
        EmitVertex(context, gap.x, ordinal++, gap.facet == kNil ? D : 2, gap.facet);
    RequestFirstComplete(context, x, gap.e2);
    if (!star_.Insert(x, gap.x)) skipped_.push_back({gap.neighbour, gap.left});
  }
  context.payload().flag = yielded || kept_out;
  if (yielded) return;
  if (by_edge()) {
    const int next = NextBucket(bucket);
    if (next < kBuckets - 1) context.Request(kComplete, v, MakeEpoch(next, 0, kQualityStep));
  } else {
    // If no neighbour in view counts, v runs again in a bucket with a wider view.
    const double nn2 = NearestInStar();
    const int own = nn2 < INFINITY ? BucketOf(nn2) : rules_.LastKnownBucket(bucket) + 1;
    if (own > bucket && own < kBuckets - 1)
      context.Request(kComplete, v, MakeEpoch(own, 0, kQualityStep));
    RequestNeighbours(context);
  }
}

// The cavity of the point in the gap of corner i begins with that corner's triangle. Next it needs
// what lies beyond this triangle and the two beside it, opposite to v: the star did not read it.
template <int D, template <class> class E>
void Refinement<D, E>::PrefetchBeyond(int i) const {
  if constexpr (D == 2) {
    for (const int k : {star_.Prev(i), i, star_.Next(i)}) {
      triangulation_->PrefetchOpposite(corners_[k]);
    }
  }
}

// The epoch at which x does the work of bucket `own`, requested by v's Complete at epoch `now`.
// That bucket, if it is later than now's. Else now's bucket: in this round if x follows v in it,
// else in the next round.
template <int D, template <class> class E>
sac::Epoch Refinement<D, E>::NoEarlierThan(sac::Epoch now, VertexIndex v, VertexIndex x,
                                           int own) const {
  const int bucket = BucketOfEpoch(now);
  if (own > bucket) return MakeEpoch(own, 0, kQualityStep);
  const std::uint64_t of_v = Priority(kComplete, v), of_x = Priority(kComplete, x);
  const bool later = of_v != of_x ? of_v < of_x : Before(kComplete, v, kComplete, x);
  return later ? now : MakeEpoch(bucket, RoundOfEpoch(now) + 1, kQualityStep);
}

// Requests x's first Complete. d2: its squared distance from its nearest neighbours.
template <int D, template <class> class E>
void Refinement<D, E>::RequestFirstComplete(Context& context, VertexIndex x, double d2) {
  const int own = BucketOf(d2);
  if (is_global() && by_edge()) {  // done when x is published
    gap_buckets_[vertices_[x].ordinal] = static_cast<std::uint16_t>(own);
    return;
  }
  RequestNoEarlierThanNow(context, x, own);
}

template <int D, template <class> class E>
void Refinement<D, E>::RequestNoEarlierThanNow(Context& context, VertexIndex x, int own) {
  context.Request(kComplete, x, NoEarlierThan(context.epoch, context.item, x, own));
}

// Facet points come first, so that facets get no vertices next to them from gaps.
template <int D, template <class> class E>
bool Refinement<D, E>::FindNext(int bucket, Candidate* next) {
  *next = {};
  if (D == 3 && !facets_.empty() && FindFacetPoint(next)) return true;
  if (!FindGap(bucket, next)) return false;
  if (D == 3 && !facets_.empty()) MoveToFacet(next);
  return true;
}

template <int D, template <class> class E>
bool Refinement<D, E>::ShortestGap(int bucket, Candidate* best) const {
  const Gaps gaps(*this);
  bool found = false;
  Candidate gap;
  for (int i = 0; i < star_.slot_count(); ++i) {
    const auto& u = star_[i];
    if (!IsInView(u) || BucketOf(u.d2) > bucket) continue;
    if (found && u.d2 > best->e2) continue;
    if (!gaps.MayHave(u.d2) || !Owns(u.id) || !gaps.OfNeighbour(i, &gap)) continue;
    if (found && gap.e2 == best->e2 && best->neighbour < gap.neighbour) continue;
    *best = gap;
    found = true;
  }
  if (!found) return false;
  best->e2 = std::min(geometry::SquaredDistance(best->x, star_.position()),
                      geometry::SquaredDistance(best->x, best->neighbour));
  return true;
}

template <int D, template <class> class E>
bool Refinement<D, E>::IsSkipped(const Point& neighbour, bool left) const {
  for (const Skipped& s : skipped_) {
    if (s.left == left && s.neighbour == neighbour) return true;
  }
  return false;
}

// --- The thesis's criterion -----------------------------------------------------------

// NN(v)^2 without seditious edges. Features are left out: no subsegment is encroached, so one that
// v is not on is at least NN(v) / sqrt 2 away.
template <int D, template <class> class E>
double Refinement<D, E>::NearestInStar() const {
  double nn2 = INFINITY;
  star_.ForEachNeighbour([&](const auto& u) {
    if (!Star::IsGhost(u.id) && u.d2 < nn2 && !IsSeditious(star_.vertex(), u.id)) nn2 = u.d2;
  });
  return nn2;
}

template <int D, template <class> class E>
bool Refinement<D, E>::FarthestCorner(int bucket, Candidate* best) const {
  const double nn2 = NearestInStar();
  if (!(nn2 < INFINITY) || BucketOf(nn2) > bucket || nn2 < rules_.least_squared_length()) {
    return false;
  }
  const Point& p = star_.position();
  bool found = false;
  double farthest = 0;
  for (int i = 0; i < star_.corner_count(); ++i) {
    const auto& n = star_.corner(i);
    if (n.r2 < farthest || !(n.error < star_.reach())) continue;
    const bool too_far = rules_.IsTooFar(n.r2, nn2) || IsTooLargeCorner(i);
    if (!too_far) continue;
    if (!InDomain(CentreOf(i)) && IsBeyondBorder(i)) continue;
    const double out = std::min(1.0, rules_.gamma() * std::sqrt(nn2) / std::sqrt(n.r2));
    Point x;
    for (int k = 0; k < D; ++k) x[k] = p[k] + n.w[k] * out;
    if (IsSkipped(x, false)) continue;
    if (found && n.r2 == farthest && best->x < x) continue;
    found = true;
    farthest = n.r2;
    best->x = best->neighbour = x;
    best->left = false;
    best->e2 = geometry::SquaredDistance(x, p);
  }
  return found;
}

// True if the ball about corner i is too large for a sizing region.
template <int D, template <class> class E>
bool Refinement<D, E>::IsTooLargeCorner(int i) const {
  const auto& n = star_.corner(i);
  return !sizing_.empty() && n.r2 > rules_.least_squared_length() &&
         sizing_.IsTooLarge(CentreOf(i), std::sqrt(n.r2));
}

// True if v lies on a side of the domain and the centre of corner i is beyond that side.
template <int D, template <class> class E>
bool Refinement<D, E>::IsBeyondBorder(int i) const {
  const auto& n = star_.corner(i);
  const Point &p = star_.position(), &lo = rules_.lo(), &hi = rules_.hi();
  for (int k = 0; k < D; ++k) {
    if ((p[k] == lo[k] && n.w[k] < 0) || (p[k] == hi[k] && n.w[k] > 0)) return true;
  }
  return false;
}

// v, a newborn at its first Complete, may be the nearest vertex of a neighbour u. Then u runs
// again, in the bucket of that distance.
template <int D, template <class> class E>
void Refinement<D, E>::RequestNeighbours(Context& context) {
  if (vertices_[star_.vertex()].epoch == kBirthOfInput) return;
  star_.ForEachNeighbour([&](const auto& u) {
    if (Star::IsGhost(u.id) || !IsOlder(u.id, star_.vertex())) return;
    bool nearest = true;
    star_.ForEachNeighbour([&](const auto& w) {
      nearest = nearest && (w.id == u.id || Star::IsGhost(w.id) ||
                            geometry::SquaredDistance(u.p, w.p) >= u.d2 || IsSeditious(u.id, w.id));
    });
    if (nearest) RequestNoEarlierThanNow(context, u.id, BucketOf(u.d2));
  });
}

// --- Later buckets ------------------------------------------------------------------

// The next bucket in which v may have work; kBuckets if there is none.
template <int D, template <class> class E>
int Refinement<D, E>::NextBucket(int bucket) const {
  const bool open = !is_global() && IsOpen();
  const int last_known = open ? rules_.LastKnownBucket(bucket) : kBuckets - 2;
  int next = open ? last_known + 1 : kBuckets;
  const Gaps gaps(*this);
  Candidate gap;
  for (int i = 0; i < star_.slot_count(); ++i) {
    const auto& u = star_[i];
    if (!IsInView(u)) continue;
    const int own = BucketOf(u.d2);
    if (own <= bucket || own > last_known || own >= next) continue;
    if (gaps.MayHave(u.d2) && Owns(u.id) && gaps.OfNeighbour(i, &gap)) next = own;
  }
  return next;
}

// May the view end within the domain? Tests for each ghost the box around the corners at it.
template <int D, template <class> class E>
bool Refinement<D, E>::IsOpen() const {
  std::array<Extent<D>, 2 * D> ends;
  ends.fill(Extent<D>::Nothing());
  for (int i = 0; i < star_.corner_count(); ++i) {
    for (const auto id : star_.IdsOf(i)) {
      if (Star::IsGhost(id)) ends[id - Star::kFirstGhost].AddBall(CentreOf(i), 0);
    }
  }
  return std::ranges::any_of(ends, [this](const Extent<D>& end) {
    for (int k = 0; k < D; ++k) {
      if (!(end.lo[k] <= rules_.hi()[k] && rules_.lo()[k] <= end.hi[k])) return false;
    }
    return true;
  });
}

template <int D, template <class> class E>
bool Refinement<D, E>::Owns(VertexIndex u) const {
  return IsOlder(u, star_.vertex());
}

// In a run from scratch the indices decide, unless both vertices are of the input or of the same
// segment work. Then u's record, which is anywhere in memory, is not read.
template <int D, template <class> class E>
inline bool Refinement<D, E>::IsOlder(VertexIndex u, VertexIndex v) const {
  if (NumbersByAge()) {
    const sac::Epoch birth = vertices_[v].epoch;
    if (IsQualityEpoch(birth) || (birth == kBirthOfInput && u >= first_made_)) {
      assert((u < v) == IsOlder(vertices_[u], vertices_[v]));
      return u < v;
    }
  }
  return IsOlder(vertices_[u], vertices_[v]);
}

template <int D, template <class> class E>
bool Refinement<D, E>::IsOlder(const Vertex& u, const Vertex& v) const {
  if (u.epoch != v.epoch) return u.epoch < v.epoch;
  if (IsQualityEpoch(u.epoch)) {
    if (u.birth != v.birth) return engine_.Precedes(u.birth, v.birth);
    return u.ordinal < v.ordinal;
  }
  const std::uint64_t hu = geometry::HashOf(u.p), hv = geometry::HashOf(v.p);
  return hu != hv ? hu < hv : u.p < v.p;
}

template <int D, template <class> class E>
bool Refinement<D, E>::InDomain(const Point& p) const {
  const Point &lo = rules_.lo(), &hi = rules_.hi();
  for (int k = 0; k < D; ++k) {
    if (!(lo[k] <= p[k] && p[k] <= hi[k])) return false;
  }
  return true;
}

// The centre of corner i of the star.
template <int D, template <class> class E>
geometry::Point<D> Refinement<D, E>::CentreOf(int i) const {
  Point centre = star_.position();
  for (int k = 0; k < D; ++k) centre[k] += star_.corner(i).w[k];
  return centre;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_COMPLETE_H_
