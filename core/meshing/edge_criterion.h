// *By edges* (the default): an edge that v owns has a gap if a corner of its Voronoi edge (3D:
// Voronoi face) is farther than rho times the edge's length. An edge is owned by its younger end
// (Complex::IsOlder). New edges always have the newborn at an end, and Voronoi edges and faces only
// shrink. So an edge without a gap stays so, and only newborns are ever queued.
//
//   v       the star's vertex          u       a neighbour
#ifndef DYNMESH_CORE_MESHING_EDGE_CRITERION_H_
#define DYNMESH_CORE_MESHING_EDGE_CRITERION_H_

#include <algorithm>
#include <array>

#include "core/geometry/constructions.h"
#include "core/meshing/candidate.h"
#include "core/meshing/complex.h"
#include "core/meshing/planar_gaps.h"
#include "core/meshing/refinement_terms.h"
#include "core/meshing/space_gaps.h"
#include "core/meshing/star.h"

namespace dynmesh::meshing {

template <int D, template <class> class E>
struct GapsOf;
template <template <class> class E>
struct GapsOf<2, E> {
  using Type = PlanarGaps<E>;
};
template <template <class> class E>
struct GapsOf<3, E> {
  using Type = SpaceGaps<E>;
};
template <int D, template <class> class E>
using GapsOfStar = typename GapsOf<D, E>::Type;

// Views the star; cheap to make.
template <int D, template <class> class E>
class EdgeCriterion {
 public:
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;

  EdgeCriterion(const Complex<D, E>& complex, const Star<D>& star, const SkippedGaps<D>& skipped)
      : complex_(complex), star_(star), skipped_(skipped) {}

  // The gap of the shortest edge with a gap in this bucket or an earlier one. False if there is
  // none.
  bool Find(int bucket, Candidate<D>* gap) const;
  // Requests what comes after the work of `bucket`: the vertex's next Complete.
  void RequestNext(Context& context, int bucket) const {
    const int next = NextBucket(bucket);
    if (next < kBuckets - 1) {
      context.Request(kComplete, star_.vertex(), MakeEpoch(next, 0, kQualityStep));
    }
  }

 private:
  // The next bucket in which the vertex may have work; kBuckets if there is none.
  int NextBucket(int bucket) const;
  bool IsOpen() const;
  // True if the star's vertex owns its edge to u.
  [[gnu::always_inline]] inline bool Owns(VertexIndex u) const {
    if (!IsOn(RefinementTerm::kOlderDoesNot)) return true;
    if (!IsOn(RefinementTerm::kYoungerOwns)) return complex_.IsOlder(star_.vertex(), u);
    return complex_.IsOlder(u, star_.vertex());
  }

  const Complex<D, E>& complex_;
  const Star<D>& star_;
  const SkippedGaps<D>& skipped_;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
bool EdgeCriterion<D, E>::Find(int bucket, Candidate<D>* best) const {
  const GapsOfStar<D, E> gaps(complex_, star_, skipped_);
  bool found = false;
  Candidate<D> gap;
  for (int i = 0; i < star_.slot_count(); ++i) {
    const auto& u = star_[i];
    if (!IsInView<D>(u)) continue;
    if (IsOn(RefinementTerm::kShorterFirst) && BucketOf(u.d2) > bucket) continue;
    if (!IsOn(RefinementTerm::kShortestFirst) && found) continue;
    if (found && u.d2 > best->e2) continue;
    if (!gaps.MayHave(u.d2) || !Owns(u.id) || !gaps.OfNeighbour(i, &gap)) continue;
    if (!IsOn(RefinementTerm::kTiesByPosition) && found && gap.e2 == best->e2) continue;
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
int EdgeCriterion<D, E>::NextBucket(int bucket) const {
  const bool open = !complex_.is_global() && IsOpen();
  const int last_known = open ? complex_.rules.LastKnownBucket(bucket) : kBuckets - 2;
  int next = open ? last_known + 1 : kBuckets;
  const GapsOfStar<D, E> gaps(complex_, star_, skipped_);
  Candidate<D> gap;
  for (int i = 0; i < star_.slot_count(); ++i) {
    const auto& u = star_[i];
    if (!IsInView<D>(u)) continue;
    const int own = BucketOf(u.d2);
    if (own <= bucket || own > last_known || own >= next) continue;
    if (gaps.MayHave(u.d2) && Owns(u.id) && gaps.OfNeighbour(i, &gap)) next = own;
  }
  return next;
}

// May the view end within the domain? Tests for each ghost the box around the corners at it.
template <int D, template <class> class E>
bool EdgeCriterion<D, E>::IsOpen() const {
  std::array<Extent<D>, 2 * D> ends;
  ends.fill(Extent<D>::Nothing());
  for (int i = 0; i < star_.corner_count(); ++i) {
    for (const auto id : star_.IdsOf(i)) {
      if (Star<D>::IsGhost(id)) ends[id - Star<D>::kFirstGhost].AddBall(CentreOf(star_, i), 0);
    }
  }
  return std::ranges::any_of(ends, [this](const Extent<D>& end) {
    for (int k = 0; k < D; ++k) {
      if (!(end.lo[k] <= complex_.rules.hi()[k] && complex_.rules.lo()[k] <= end.hi[k]))
        return false;
    }
    return true;
  });
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_EDGE_CRITERION_H_
