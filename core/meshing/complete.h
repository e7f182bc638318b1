// Complete (rule a): insert Steiner points until there is no gap in this bucket or an
// earlier one. Two criteria of what a gap is:
//
// *By edges* (ours, the default): no edge that v owns has a gap on either side, that
// is, a corner of its Voronoi edge farther than rho times its own length. An edge is owned by its
// younger end: born in a later epoch or by a later operation; of two born together in segment work
// or with the input, the one of greater hash. New edges always have the newborn at an end, and
// Voronoi edges only shrink: an edge done once is done for good, so only newborns ever have to be
// queued.
//
// *The thesis's* (Def. 4.2.3): no corner of v's Voronoi cell is farther than
// rho NN(v). Every vertex sees to its own cell; a newborn queues those whose NN it may
// have lowered (Fig. 5.6, INSERT).
//
//   v       the vertex          b       the bucket of its epoch
//   u       a neighbour         c, d    apexes of the triangles left and right of vu
#ifndef DYNMESH_CORE_MESHING_COMPLETE_H_
#define DYNMESH_CORE_MESHING_COMPLETE_H_

#include <algorithm>
#include <cassert>

#include "core/geometry/constructions.h"
#include "core/meshing/refinement.h"

namespace dynmesh::meshing {

// ComputeNN. Edges of v are at least NN(v) long: nothing to do in earlier buckets.
template <template <class> class E>
void Refinement<E>::Nearest(Context& context) {
  const VertexIndex v = context.item;
  const double d2 = NearestDistance2(context, v);
  context.payload().radius2 = RoundedUp(d2);
  context.Request(kComplete, v, MakeEpoch(BucketOf(d2), 0, kQualityStep));
  if constexpr (kTraced) {
    Extent<2> box = Extent<2>::Nothing();
    box.AddBall(vertices_[v].p, std::sqrt(d2) * (1 + 1e-9) + 2 * rules_.ulp());
    SubscribeBox(context, box);
  }
}

template <template <class> class E>
void Refinement<E>::Complete(Context& context) {
  const VertexIndex v = context.item;
  const int bucket = BucketOfEpoch(context.epoch);
  const std::uint64_t next_round = RoundOfEpoch(context.epoch) + 1;
  FindStar(context, v, rules_.Reach(bucket));

  skipped_.clear();
  Candidate gap;
  int ordinal = 0;
  bool yielded = false, kept_out = false;
  // Each point fills its gap, and there is room for a few only. Should a view be wrong, so
  // that neither is true, the loop ends all the same.
  while (ordinal < kMostOutputs && FindGap(bucket, &gap)) {
    FindEncroached(context, gap.x);
    if (!encroached_.empty()) {
      // Yield: the subsegments first; then v looks again. One that is not to be split any
      // more keeps the point out for good.
      const bool is_guarded = std::ranges::any_of(
          encroached_, [&](SubsegmentIndex s) { return IsGuarded(subsegments_[s], bucket); });
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
    if (is_global() && by_edge() && ordinal == 0) gap_triangle_ = corners_[gap.corner].triangle;
    const VertexIndex x = EmitVertex(context, gap.x, ordinal++, 2, kNil);
    RequestFirstComplete(context, x, gap.e2);
    if (!star_.Insert(x, gap.x)) skipped_.push_back({gap.neighbour, gap.left});
  }
  context.payload().flag = yielded || kept_out;
  if (yielded) return;
  if (by_edge()) {
    const int next = NextBucket(bucket);
    if (next < kBuckets - 1) context.Request(kComplete, v, MakeEpoch(next, 0, kQualityStep));
  } else {
    // With nobody in view that counts, v looks again when views are wider.
    const double nn2 = NearestInStar();
    const int own = nn2 < INFINITY ? BucketOf(nn2) : rules_.LastKnownBucket(bucket) + 1;
    if (own > bucket && own < kBuckets - 1)
      context.Request(kComplete, v, MakeEpoch(own, 0, kQualityStep));
    RequestNeighbours(context);
  }
}

// When is x, asked for at epoch `now` by v's Complete, to do what belongs to bucket `own`?
// Then, or if that has come, now: later in this round if its turn is still to come, else in
// the next.
template <template <class> class E>
sac::Epoch Refinement<E>::NoEarlierThan(sac::Epoch now, VertexIndex v, VertexIndex x,
                                        int own) const {
  const int bucket = BucketOfEpoch(now);
  if (own > bucket) return MakeEpoch(own, 0, kQualityStep);
  const std::uint64_t of_v = Priority(kComplete, v), of_x = Priority(kComplete, x);
  const bool later = of_v != of_x ? of_v < of_x : Before(kComplete, v, kComplete, x);
  return later ? now : MakeEpoch(bucket, RoundOfEpoch(now) + 1, kQualityStep);
}

// x, at squared distance d2 from its nearest neighbours, has something to do.
template <template <class> class E>
void Refinement<E>::RequestFirstComplete(Context& context, VertexIndex x, double d2) {
  if (is_global() && by_edge()) return;  // done when x is published
  RequestNoEarlierThanNow(context, x, BucketOf(d2));
}

template <template <class> class E>
void Refinement<E>::RequestNoEarlierThanNow(Context& context, VertexIndex x, int own) {
  context.Request(kComplete, x, NoEarlierThan(context.epoch, context.item, x, own));
}

template <template <class> class E>
bool Refinement<E>::ShortestGap(int bucket, Candidate* best) const {
  bool found = false;
  Candidate gap;
  for (int i = 0; i < star_.size(); ++i) {
    const Star::Neighbour& u = star_[i];
    if (Star::IsGhost(u.id) || BucketOf(u.d2) > bucket) continue;
    if (found && u.d2 > best->e2) continue;
    for (const bool left_of_star : {true, false}) {
      if (!GapOfEdge(i, left_of_star, &gap) || !Owns(i)) continue;
      if (!found || gap.e2 < best->e2 ||
          (gap.e2 == best->e2 && (gap.neighbour < best->neighbour ||
                                  (gap.neighbour == best->neighbour && gap.left && !best->left)))) {
        *best = gap;
        found = true;
      }
    }
  }
  if (!found) return false;
  best->e2 = std::min(geometry::SquaredDistance(best->x, star_.position()),
                      geometry::SquaredDistance(best->x, best->neighbour));
  return true;
}

// --- The thesis's criterion -----------------------------------------------------------

// NN(v)^2, seditious edges left out. Features need no mention: no subsegment is encroached, so one
// that v is not on is at least NN(v) / sqrt 2 away.
template <template <class> class E>
double Refinement<E>::NearestInStar() const {
  double nn2 = INFINITY;
  for (int i = 0; i < star_.size(); ++i) {
    const VertexIndex u = star_[i].id;
    if (!Star::IsGhost(u) && star_[i].d2 < nn2 && !IsSeditious(star_.vertex(), u)) {
      nn2 = star_[i].d2;
    }
  }
  return nn2;
}

template <template <class> class E>
bool Refinement<E>::FarthestCorner(int bucket, Candidate* best) const {
  const double nn2 = NearestInStar();
  if (!(nn2 < INFINITY) || BucketOf(nn2) > bucket || nn2 < rules_.least_squared_length()) {
    return false;
  }
  const Point2& p = star_.position();
  bool found = false;
  double farthest = 0;
  for (int i = 0; i < star_.size(); ++i) {
    const Star::Neighbour& n = star_[i];
    if (n.r2 < farthest || !(n.centre_error < star_.reach())) continue;
    const bool too_far = rules_.IsTooFar(n.r2, nn2) ||
                         (!sizing_.empty() && n.r2 > rules_.least_squared_length() &&
                          sizing_.IsTooLarge({{p[0] + n.wx, p[1] + n.wy}}, std::sqrt(n.r2)));
    if (!too_far) continue;
    if (!InDomain({{p[0] + n.wx, p[1] + n.wy}}) && IsBeyondBorder(i)) continue;
    const double out = std::min(1.0, rules_.gamma() * std::sqrt(nn2) / std::sqrt(n.r2));
    const Point2 x = {{p[0] + n.wx * out, p[1] + n.wy * out}};
    if (std::ranges::any_of(skipped_, [&](const Skipped& s) { return s.neighbour == x; })) continue;
    if (found && n.r2 == farthest && best->x < x) continue;
    found = true;
    farthest = n.r2;
    best->x = best->neighbour = x;
    best->left = false;
    best->e2 = geometry::SquaredDistance(x, p);
  }
  return found;
}

// Is corner i between neighbours, or ghosts, of which none is inside the domain's side
// that v lies on?
template <template <class> class E>
bool Refinement<E>::IsBeyondBorder(int i) const {
  const Star::Neighbour& n = star_[i];
  const Point2& p = star_.position();
  const Point2 &lo = rules_.lo(), &hi = rules_.hi();
  return (p[1] == lo[1] && n.wy < 0) || (p[1] == hi[1] && n.wy > 0) ||
         (p[0] == lo[0] && n.wx < 0) || (p[0] == hi[0] && n.wx > 0);
}

// v, a newborn at its first Complete, may be nearer to a neighbour u than anyone was:
// then u has to look again, in the bucket of that distance.
template <template <class> class E>
void Refinement<E>::RequestNeighbours(Context& context) {
  const Vertex& v = vertices_[star_.vertex()];
  if (v.epoch == kBirthOfInput) return;
  for (int i = 0; i < star_.size(); ++i) {
    const Star::Neighbour& u = star_[i];
    if (Star::IsGhost(u.id) || !IsOlder(vertices_[u.id], v)) continue;
    bool nearest = true;
    for (int j = 0; j < star_.size() && nearest; ++j) {
      nearest = j == i || Star::IsGhost(star_[j].id) ||
                geometry::SquaredDistance(u.p, star_[j].p) >= u.d2 ||
                IsSeditious(u.id, star_[j].id);
    }
    if (nearest) RequestNoEarlierThanNow(context, u.id, BucketOf(u.d2));
  }
}

// --- The edge criterion ---------------------------------------------------------------

// Has the i-th edge of the star a gap on that side which a point may be put into?
template <template <class> class E>
bool Refinement<E>::GapOfEdge(int i, bool left_of_star, Candidate* gap) const {
  const Star::Neighbour& u = star_[i];
  const Star::Neighbour& c = star_[left_of_star ? star_.Next(i) : star_.Prev(i)];
  const Star::Neighbour& d = star_[left_of_star ? star_.Prev(i) : star_.Next(i)];
  // (p, q, c) is counter-clockwise.
  const Point2& p = left_of_star ? star_.position() : u.p;
  const Point2& q = left_of_star ? u.p : star_.position();
  if (Star::IsGhost(c.id) && OnOutside(p, q)) return false;
  const Gap what =
      GapOf(star_.vertex(), p, u.id, q, u.d2, c.id, Star::IsGhost(c.id) ? nullptr : &c.p,
            Star::IsGhost(d.id) ? nullptr : &d.p);
  if (what == Gap::kNone) return false;
  gap->e2 = u.d2;
  gap->neighbour = u.p;
  gap->left = p < q;
  gap->corner = left_of_star ? i : star_.Prev(i);
  for (const Skipped& s : skipped_) {
    if (s.left == gap->left && s.neighbour == gap->neighbour) return false;
  }
  gap->x = what == Gap::kOffCenter ? rules_.OffCenter(p, q) : geometry::Circumcenter(p, q, c.p);
  return true;
}

// The gap of edge vu as the rules see it, or that its triangle with w is too large for a
// sizing feature; p, q, c: the ends and w's place as for the rules.
template <template <class> class E>
[[gnu::always_inline]] inline Gap Refinement<E>::GapOf(VertexIndex v, const Point2& p,
                                                       VertexIndex u, const Point2& q, double e2,
                                                       VertexIndex w, const Point2* c,
                                                       const Point2* d) const {
  const Gap gap = rules_.GapOfEdge(p, q, e2, c, d);
  if (gap != Gap::kNone) return IsSeditious(v, u) ? Gap::kNone : gap;
  return !sizing_.empty() && c != nullptr ? SizeGap(v, p, u, q, e2, w, *c) : Gap::kNone;
}

// A triangle stays as large as it is: the last of its corners to come deals with it, at one of
// its own two edges that have the circumcenter on the third corner's side. So here, too,
// newborns only need be queued.
template <template <class> class E>
Gap Refinement<E>::SizeGap(VertexIndex v, const Point2& p, VertexIndex u, const Point2& q,
                           double e2, VertexIndex w, const Point2& c) const {
  if (!IsTooLarge(p, q, c, e2)) return Gap::kNone;
  const VertexIndex younger = IsOlder(vertices_[v], vertices_[u]) ? u : v;
  const bool owned = IsOlder(vertices_[w], vertices_[younger]);
  return owned && !IsSeditious(v, u) ? Gap::kCircumcenter : Gap::kNone;
}

template <template <class> class E>
bool Refinement<E>::IsTooLarge(const Point2& p, const Point2& q, const Point2& c, double e2) const {
  const double px = p[0] - c[0], py = p[1] - c[1], qx = q[0] - c[0], qy = q[1] - c[1];
  if (e2 < rules_.least_squared_length() || !(px * qx + py * qy > 0)) return false;
  const Point2 x = geometry::Circumcenter(p, q, c);
  const double r2 = std::max(geometry::SquaredDistance(x, p), geometry::SquaredDistance(x, q));
  return r2 > rules_.least_squared_length() && sizing_.IsTooLarge(x, std::sqrt(r2));
}

// The next bucket in which v may have something to do; kBuckets if none.
template <template <class> class E>
int Refinement<E>::NextBucket(int bucket) const {
  bool open = false;  // does the view end within the domain?
  for (int i = 0; i < star_.size() && !is_global(); ++i) {
    const Star::Neighbour& n = star_[i];
    if (!Star::IsGhost(n.id) && !Star::IsGhost(star_[star_.Next(i)].id)) continue;
    const Point2& p = star_.position();
    if (InDomain({{p[0] + n.wx, p[1] + n.wy}})) open = true;
  }
  const int last_known = open ? rules_.LastKnownBucket(bucket) : kBuckets - 2;
  int next = open ? last_known + 1 : kBuckets;
  Candidate gap;
  for (int i = 0; i < star_.size(); ++i) {
    const Star::Neighbour& u = star_[i];
    if (Star::IsGhost(u.id)) continue;
    const int own = BucketOf(u.d2);
    if (own <= bucket || own > last_known || own >= next) continue;
    if ((GapOfEdge(i, true, &gap) || GapOfEdge(i, false, &gap)) && Owns(i)) next = own;
  }
  return next;
}

template <template <class> class E>
bool Refinement<E>::Owns(int i) const {
  return IsOlder(vertices_[star_[i].id], vertices_[star_.vertex()]);
}

template <template <class> class E>
bool Refinement<E>::IsOlder(const Vertex& u, const Vertex& v) const {
  if (u.epoch != v.epoch) return u.epoch < v.epoch;
  if (u.epoch != kBirthOfInput && IsQualityEpoch(u.epoch)) {
    if (u.birth != v.birth) return engine_.Precedes(u.birth, v.birth);
    return u.ordinal < v.ordinal;
  }
  const std::uint64_t hu = geometry::HashOf(u.p), hv = geometry::HashOf(v.p);
  return hu != hv ? hu < hv : u.p < v.p;
}

// Is the left side of pq outside of the domain?
template <template <class> class E>
bool Refinement<E>::OnOutside(const Point2& p, const Point2& q) const {
  const Point2 &lo = rules_.lo(), &hi = rules_.hi();
  return (p[1] == lo[1] && q[1] == lo[1] && q[0] < p[0]) ||
         (p[1] == hi[1] && q[1] == hi[1] && q[0] > p[0]) ||
         (p[0] == lo[0] && q[0] == lo[0] && q[1] > p[1]) ||
         (p[0] == hi[0] && q[0] == hi[0] && q[1] < p[1]);
}

template <template <class> class E>
bool Refinement<E>::InDomain(const Point2& p) const {
  const Point2 &lo = rules_.lo(), &hi = rules_.hi();
  return lo[0] <= p[0] && p[0] <= hi[0] && lo[1] <= p[1] && p[1] <= hi[1];
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_COMPLETE_H_
