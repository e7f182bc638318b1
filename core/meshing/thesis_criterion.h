// *The thesis's* criterion (Def. 4.2.3), an option: no corner of v's Voronoi cell is farther than
// rho NN(v). Every vertex deals with its own cell. A newborn queues its neighbours where it may
// have lowered their NN (Fig. 5.6, INSERT). It is the baseline of the thesis's experiments.
//
//   v       the star's vertex          u       a neighbour
#ifndef DYNMESH_CORE_MESHING_THESIS_CRITERION_H_
#define DYNMESH_CORE_MESHING_THESIS_CRITERION_H_

#include <algorithm>
#include <cmath>

#include "core/meshing/candidate.h"
#include "core/meshing/complex.h"
#include "core/meshing/order.h"
#include "core/meshing/star.h"

namespace dynmesh::meshing {

// Views the star; cheap to make.
template <int D, template <class> class E>
class ThesisCriterion {
 public:
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;

  ThesisCriterion(const Complex<D, E>& complex, const Star<D>& star, const SkippedGaps<D>& skipped)
      : complex_(complex), star_(star), skipped_(skipped) {}

  // The farthest corner that is too far, if NN(v) is in this bucket or an earlier one. False if
  // there is none.
  bool Find(int bucket, Candidate<D>* gap) const;
  // Requests what comes after the work of `bucket`: the vertex's next Complete, and those of
  // neighbours.
  void RequestNext(Context& context, int bucket) const {
    // If no neighbour in view counts, v runs again in a bucket with a wider view.
    const double nn2 = NearestInStar();
    const int own = nn2 < INFINITY ? BucketOf(nn2) : complex_.rules.LastKnownBucket(bucket) + 1;
    if (own > bucket && own < kBuckets - 1) {
      context.Request(kComplete, star_.vertex(), MakeEpoch(own, 0, kQualityStep));
    }
    RequestNeighbours(context);
  }

 private:
  double NearestInStar() const;
  bool IsBeyondBorder(int i) const;
  void RequestNeighbours(Context& context) const;

  const Complex<D, E>& complex_;
  const Star<D>& star_;
  const SkippedGaps<D>& skipped_;
};

// --- Implementation -------------------------------------------------------------------------

// NN(v)^2 without seditious edges. Features are left out: no subsegment is encroached, so one that
// v is not on is at least NN(v) / sqrt 2 away.
template <int D, template <class> class E>
double ThesisCriterion<D, E>::NearestInStar() const {
  double nn2 = INFINITY;
  star_.ForEachNeighbour([&](const auto& u) {
    if (!Star<D>::IsGhost(u.id) && u.d2 < nn2 && !complex_.IsSeditious(star_.vertex(), u.id))
      nn2 = u.d2;
  });
  return nn2;
}

template <int D, template <class> class E>
bool ThesisCriterion<D, E>::Find(int bucket, Candidate<D>* best) const {
  const double nn2 = NearestInStar();
  if (!(nn2 < INFINITY) || BucketOf(nn2) > bucket || nn2 < complex_.rules.least_squared_length()) {
    return false;
  }
  const Point& p = star_.position();
  bool found = false;
  double farthest = 0;
  for (int i = 0; i < star_.corner_count(); ++i) {
    const auto& n = star_.corner(i);
    if (n.r2 < farthest || !(n.error < star_.reach())) continue;
    const bool too_far =
        complex_.rules.IsTooFar(n.r2, nn2) || complex_.IsTooLarge(CentreOf(star_, i), n.r2);
    if (!too_far) continue;
    if (!complex_.InDomain(CentreOf(star_, i)) && IsBeyondBorder(i)) continue;
    const double out = std::min(1.0, complex_.rules.gamma() * std::sqrt(nn2) / std::sqrt(n.r2));
    Point x;
    for (int k = 0; k < D; ++k) x[k] = p[k] + n.w[k] * out;
    if (skipped_.Has(x, false)) continue;
    if (found && n.r2 == farthest && best->x < x) continue;
    found = true;
    farthest = n.r2;
    best->x = best->neighbour = x;
    best->left = false;
    best->e2 = geometry::SquaredDistance(x, p);
  }
  return found;
}

// True if v lies on a side of the domain and the centre of corner i is beyond that side.
template <int D, template <class> class E>
bool ThesisCriterion<D, E>::IsBeyondBorder(int i) const {
  const auto& n = star_.corner(i);
  const Point &p = star_.position(), &lo = complex_.rules.lo(), &hi = complex_.rules.hi();
  for (int k = 0; k < D; ++k) {
    if ((p[k] == lo[k] && n.w[k] < 0) || (p[k] == hi[k] && n.w[k] > 0)) return true;
  }
  return false;
}

// v, a newborn at its first Complete, may be the nearest vertex of a neighbour u. Then u runs
// again, in the bucket of that distance.
template <int D, template <class> class E>
void ThesisCriterion<D, E>::RequestNeighbours(Context& context) const {
  if (complex_.vertex(star_.vertex()).epoch == kBirthOfInput) return;
  star_.ForEachNeighbour([&](const auto& u) {
    if (Star<D>::IsGhost(u.id) || !complex_.IsOlder(u.id, star_.vertex())) return;
    bool nearest = true;
    star_.ForEachNeighbour([&](const auto& w) {
      nearest = nearest &&
                (w.id == u.id || Star<D>::IsGhost(w.id) ||
                 geometry::SquaredDistance(u.p, w.p) >= u.d2 || complex_.IsSeditious(u.id, w.id));
    });
    if (nearest) RequestNoEarlierThanNow(complex_, context, u.id, BucketOf(u.d2));
  });
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_THESIS_CRITERION_H_
