// Complete (rule a): inserts Steiner points until there is no gap in this bucket or an earlier one.
// Two criteria define a gap: edge_criterion.h, the default, and thesis_criterion.h. A point that
// would encroach on subsegments is not inserted: it *yields*, they are split first (rule c).
//
//   v       the vertex          x       a point in a gap
#ifndef DYNMESH_CORE_MESHING_COMPLETE_H_
#define DYNMESH_CORE_MESHING_COMPLETE_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/meshing/candidate.h"
#include "core/meshing/complex.h"
#include "core/meshing/edge_criterion.h"
#include "core/meshing/emitter.h"
#include "core/meshing/encroachment.h"
#include "core/meshing/facet_work.h"
#include "core/meshing/idle_star.h"
#include "core/meshing/link.h"
#include "core/meshing/order.h"
#include "core/meshing/refinement_terms.h"
#include "core/meshing/splits.h"
#include "core/meshing/star_finder.h"
#include "core/meshing/thesis_criterion.h"

namespace dynmesh::meshing {

// The procedure kComplete. Thread-compatible.
template <int D, template <class> class E>
class CompleteWork {
 public:
  using Context = ContextOf<D, E>;

  CompleteWork(const Complex<D, E>& complex, Emitter<D, E>& emitter)
      : complex_(complex),
        emitter_(emitter),
        stars_(complex),
        idle_stars_(complex),
        search_(complex),
        facets_(complex) {}
  void Run(Context& context);

  // In a global run: about the points that the last Run inserted, for their publication, which
  // comes next (Refinement::PublishInGlobal). It decides epochs: with others the mesh is another
  // one.
  struct Filled {
    // 2D: the triangle with the gap that the first point fills.
    std::uint32_t triangle = TriangulationOf<D>::kNone;
    // The bucket of the gap that a point fills, by the point's ordinal.
    std::array<std::uint16_t, kMostOutputs> buckets = {};
  };
  const Filled& filled() const { return filled_; }

 private:
  using Link = LinkOf<D>;
  using Encroached = typename EncroachmentSearch<D, E>::Encroached;

  template <class Gaps>
  void Fill(Context& context, Star<D>& star, const Link* link);
  template <class Gaps>
  bool FindNext(const Gaps& gaps, const Star<D>& star, int bucket, Candidate<D>* next);
  bool WasKeptOut(const Star<D>& star, const Candidate<D>& gap, int bucket) const;
  bool MaySplitAll(std::span<const Encroached> encroached, const Candidate<D>& gap, int bucket,
                   bool* kept_out);
  void Yield(Context& context, std::span<const Encroached> encroached);
  void Insert(Context& context, Star<D>& star, const Link* link, const Candidate<D>& gap,
              int ordinal);
  void PrefetchBeyond(const Star<D>& star, const Link& link, int i) const;

  const Complex<D, E>& complex_;
  Emitter<D, E>& emitter_;
  StarFinder<D, E> stars_;
  IdleStars<D, E> idle_stars_;
  EncroachmentSearch<D, E> search_;
  FacetWork<D, E> facets_;
  SkippedGaps<D> skipped_;
  Filled filled_;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
void CompleteWork<D, E>::Run(Context& context) {
  const VertexIndex v = context.item;
  const double reach = complex_.rules.Reach(BucketOfEpoch(context.epoch));
  Link* const link = stars_.FindLink(v);
  if (link != nullptr && idle_stars_.Read(context, v, reach, *link)) return;
  if (link != nullptr && facets_.is_needed() && idle_stars_.IsDone(v, *link)) return;
  Star<D>& star = stars_.Find(context, v, reach, link);
  if (complex_.by_edge()) {
    Fill<EdgeCriterion<D, E>>(context, star, link);
  } else {
    Fill<ThesisCriterion<D, E>>(context, star, link);
  }
}

// Inserts points until no gap is left, or until one yields.
template <int D, template <class> class E>
template <class Gaps>
void CompleteWork<D, E>::Fill(Context& context, Star<D>& star, const Link* link) {
  const int bucket = BucketOfEpoch(context.epoch);
  const Gaps gaps(complex_, star, skipped_);
  skipped_.Clear();
  Candidate<D> gap;
  int ordinal = 0;
  bool yielded = false, kept_out = false;
  // Each point fills its gap, and there is room for only a few. The bound kMostOutputs ends the
  // loop even if a wrong view violates this.
  while (!yielded && ordinal < kMostOutputs && FindNext(gaps, star, bucket, &gap)) {
    if (!complex_.unsplit.empty() && WasKeptOut(star, gap, bucket)) {
      kept_out = true;
      skipped_.Add(gap);
      continue;
    }
    const auto encroached = search_.EncroachedBy(context, gap.x);
    if (encroached.empty() || !IsOn(RefinementTerm::kYields)) {
      Insert(context, star, link, gap, ordinal++);
    } else if (MaySplitAll(encroached, gap, bucket, &kept_out)) {
      Yield(context, encroached);
      yielded = true;
    } else {
      skipped_.Add(gap);
    }
  }
  context.payload().flag = yielded || kept_out;
  if (!yielded) gaps.RequestNext(context, bucket);
}

// Facet points come first, so that facets get no vertices next to them from gaps.
template <int D, template <class> class E>
template <class Gaps>
bool CompleteWork<D, E>::FindNext(const Gaps& gaps, const Star<D>& star, int bucket,
                                  Candidate<D>* next) {
  *next = {};
  if (facets_.is_needed() && IsOn(RefinementTerm::kFacetsCovered) &&
      facets_.FindPoint(star, skipped_, next)) {
    return true;
  }
  if (!gaps.Find(bucket, next)) return false;
  if (facets_.is_needed()) facets_.MoveToFacet(star, next);
  return true;
}

// A gap that an unsplit segment has kept open in an earlier bucket stays so. Its triangle may be
// another one since, with a point that encroaches on nothing; but whether v runs in this bucket
// depends on how neighbourhoods are found (run.h), and no result may.
//
// An edge of v, its owner, is as old as v. So its gaps were tried at the first Complete of v in
// their own bucket or later. The points tried were on the bisector of the edge, no farther out than
// the off-center, as Voronoi edges only shrink.
template <int D, template <class> class E>
bool CompleteWork<D, E>::WasKeptOut(const Star<D>& star, const Candidate<D>& gap,
                                    int bucket) const {
  if constexpr (D == 2) {
    const auto &v = star.position(), &u = gap.neighbour;
    const int own = BucketOf(geometry::SquaredDistance(v, u)),
              of_birth = BucketOfEpoch(complex_.vertex(star.vertex()).epoch);
    if (bucket <= std::max(own, of_birth)) return false;
    const auto &lesser = std::min(v, u), &greater = std::max(v, u);
    const auto off_center = gap.left ? complex_.rules.OffCenter(lesser, greater)
                                     : complex_.rules.OffCenter(greater, lesser);
    return complex_.unsplit.Meet(geometry::Midpoint(v, u), off_center);
  }
  return false;
}

// False if a subsegment that `gap` encroaches on may not be split (any more): then it keeps the
// point out for good. *kept_out: becomes true if that is due to the guard, or if it is unsplit.
template <int D, template <class> class E>
bool CompleteWork<D, E>::MaySplitAll(std::span<const Encroached> encroached,
                                     const Candidate<D>& gap, int bucket, bool* kept_out) {
  const bool is_kept_whole = std::ranges::any_of(
      encroached, [&](const auto& e) { return IsUnsplit(complex_.subsegment(e.s)); });
  if (is_kept_whole && IsOn(RefinementTerm::kUnsplitKeepsOut)) {
    *kept_out = true;
    return false;
  }
  const bool may_be_guarded = IsOn(RefinementTerm::kGuardEnds) && !gap.required;
  const bool is_guarded = may_be_guarded && std::ranges::any_of(encroached, [&](const auto& e) {
                            return IsGuarded(complex_, complex_.subsegment(e.s), bucket);
                          });
  if (is_guarded) {
    *kept_out = true;
    return false;
  }
  const bool can = std::ranges::all_of(
      encroached, [&](const auto& e) { return CanSplit(complex_, complex_.subsegment(e.s)); });
  if (!can) emitter_.NoteDepthLimit();
  return can;
}

// The subsegments are split first, then v runs again.
template <int D, template <class> class E>
void CompleteWork<D, E>::Yield(Context& context, std::span<const Encroached> encroached) {
  const int bucket = BucketOfEpoch(context.epoch);
  const std::uint64_t next_round = RoundOfEpoch(context.epoch) + 1;
  for (const auto& e : encroached) {
    context.Request(kSplit, e.s, MakeEpoch(bucket, next_round, 0));
  }
  if (!IsOn(RefinementTerm::kRunsAgain)) return;
  context.Request(kComplete, context.item, MakeEpoch(bucket, next_round, kQualityStep));
}

template <int D, template <class> class E>
void CompleteWork<D, E>::Insert(Context& context, Star<D>& star, const Link* link,
                                const Candidate<D>& gap, int ordinal) {
  const bool is_global = complex_.is_global();
  if constexpr (D == 2) {
    if (is_global && ordinal == 0) {
      filled_.triangle = link->corners[gap.corner].simplex;
      PrefetchBeyond(star, *link, gap.corner);
    }
  }
  const VertexIndex x = emitter_.EmitVertex(context, gap.x, ordinal, gap.facet == kNil ? D : 2,
                                            gap.facet, gap.origin);
  const int own = BucketOf(gap.e2);
  if (is_global) {  // requested when x is published (FirstGaps)
    filled_.buckets[static_cast<std::size_t>(ordinal)] = static_cast<std::uint16_t>(own);
  } else {
    RequestNoEarlierThanNow(complex_, context, x, own);
  }
  if (!star.Insert(x, gap.x)) skipped_.Add(gap);
}

// The cavity of the point in the gap of corner i begins with that corner's triangle. Next it needs
// what lies beyond this triangle and the two beside it, opposite to v: the star did not read it.
template <int D, template <class> class E>
void CompleteWork<D, E>::PrefetchBeyond(const Star<D>& star, const Link& link, int i) const {
  if constexpr (D == 2) {
    for (const int k : {star.Prev(i), i, star.Next(i)}) {
      complex_.run.triangulation().PrefetchOpposite(link.corners[k]);
    }
  }
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_COMPLETE_H_
