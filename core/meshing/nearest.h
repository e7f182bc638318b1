// ComputeNN: the bucket of a vertex's first Complete, that of its nearest neighbour's distance.
//
// Only the bucket decides. So where very many vertices are in that bucket, as on a circle about v,
// a search ends at the bucket's least distance. The thesis asks later instead, at a lower bound of
// the distance (Fig. 4.7, line 7).
#ifndef DYNMESH_CORE_MESHING_NEAREST_H_
#define DYNMESH_CORE_MESHING_NEAREST_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/base/rounding.h"
#include "core/meshing/complex.h"
#include "core/meshing/facet_work.h"
#include "core/meshing/refinement_terms.h"
#include "core/meshing/rules.h"

namespace dynmesh::meshing {

// The procedure kNearest. Thread-compatible.
template <int D, template <class> class E>
class NearestWork {
 public:
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;

  explicit NearestWork(const Complex<D, E>& complex) : complex_(complex), facets_(complex) {}

  // Edges of v have length >= NN(v), so there is no work in earlier buckets.
  void Run(Context& context);
  // Call after a run from scratch.
  void Forget() { all_ = std::vector<Near>(); }
  // How many vertices were looked at so far, other than in FindAll.
  std::uint64_t looked_at() const { return looked_at_; }

 private:
  static constexpr int kMany = 64;

  struct Near {
    double d2 = INFINITY;  // squared distance
    VertexIndex v = kNil;
  };
  // The nearest of the first kMany vertices found in its bucket.
  Near Find(const Context& context, VertexIndex v);
  void FindAll();

  const Complex<D, E>& complex_;
  FacetWork<D, E> facets_;
  std::uint64_t looked_at_ = 0;
  std::vector<Near> all_;  // from scratch: by vertex; computed at the first query
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
void NearestWork<D, E>::Run(Context& context) {
  const VertexIndex v = context.item;
  const Near nearest = Find(context, v);
  int bucket = BucketOf(nearest.d2);
  if (facets_.is_needed() && IsOn(RefinementTerm::kFacetIsNear)) {
    bucket = std::min(bucket, BucketOf(facets_.Distance2(v, LeastOfBucket(bucket))));
  }
  context.Request(kComplete, v, MakeEpoch(bucket, 0, kQualityStep));
  if constexpr (kTraced) {
    // A vertex farther away than a facet has no effect. When it vanishes, that is not notified.
    if (nearest.v != kNil && bucket == BucketOf(nearest.d2)) context.Read(nearest.v);
    // The whole bucket: neither depends on which vertex was found.
    const double far2 = EndOfBucket(bucket);
    context.payload().radius2 = RoundedUp(far2);
    Extent<D> box = Extent<D>::Nothing();
    box.AddBall(complex_.vertex(v).p, std::sqrt(far2) * kBarelyWider + 2 * complex_.rules.ulp());
    complex_.Subscribe(context, box);
  }
}

template <int D, template <class> class E>
typename NearestWork<D, E>::Near NearestWork<D, E>::Find(const Context& context, VertexIndex v) {
  if (complex_.run.has_triangulation()) {
    if (all_.empty()) FindAll();
    return all_[v];
  }
  Near best;
  double r2 = INFINITY;
  int bucket = kBuckets, found = 0;  // the bucket of `best`, and how many were found in it
  complex_.tree.VisitBall(complex_.vertex(v).p, r2, [&](std::uint32_t id, const Point&, double d2) {
    ++looked_at_;
    const int its = BucketOf(d2);
    if (id == v || its > bucket || !context.Sees(complex_.vertex(id).birth)) return;
    found = its < bucket ? 1 : found + 1;
    bucket = its;
    if (d2 < best.d2) best = {d2, id};
    r2 = found < kMany ? EndOfBucket(bucket) : LeastOfBucket(bucket);
  });
  return best;
}

// Finds all nearest neighbours at once, as the nearest neighbour is a Delaunay neighbour. A pass
// over the triangles is faster than vertex by vertex in random order. Nothing is inserted in that
// epoch.
template <int D, template <class> class E>
void NearestWork<D, E>::FindAll() {
  all_.assign(complex_.elements.vertex_end(), {});
  complex_.run.triangulation().ForEachSimplex([&](auto t) {
    const auto& corners = complex_.run.triangulation().vertices(t);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const VertexIndex p = corners[i], q = corners[j];
        const double d2 = geometry::SquaredDistance(complex_.run.triangulation().position(p),
                                                    complex_.run.triangulation().position(q));
        if (d2 < all_[p].d2) all_[p] = {d2, q};
        if (d2 < all_[q].d2) all_[q] = {d2, p};
      }
    }
  });
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_NEAREST_H_
