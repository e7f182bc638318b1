// In a global run (run.h) only vertices that own a gap are ever queued.
//
// Once the input's subsegments are settled, all present gaps are found at once, triangle by
// triangle; later gaps when their owner, the newborn, is published. The segment work of bucket 0
// comes first. So the pass is an operation of kind kNearest, which has the last step of bucket 0.
#ifndef DYNMESH_CORE_MESHING_FIRST_GAPS_H_
#define DYNMESH_CORE_MESHING_FIRST_GAPS_H_

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/meshing/complex.h"
#include "core/meshing/order.h"
#include "core/meshing/planar_gaps.h"
#include "core/meshing/space_gaps.h"

namespace dynmesh::meshing {

// Thread-compatible.
template <int D, template <class> class E>
class FirstGaps {
 public:
  FirstGaps(const Complex<D, E>& complex, EngineOf<D, E>& engine)
      : complex_(complex), engine_(engine) {}

  // Requests the first operations of all vertices. Call when a propagation begins.
  void RequestAll();
  // Requests the Completes of all vertices that own a gap. Call when the input's subsegments are
  // settled. Later calls do nothing.
  void FindAll();
  // Requests v's Complete if v owns a gap. A Complete has just inserted v, so v owns all its edges.
  // Its first Complete is not before bucket `least`, that of its nearest neighbours, the vertices
  // of the gap that it fills, as in a traced run. By rounding the third corner may be slightly
  // nearer, and in an earlier bucket.
  void FindOf(VertexIndex v, int least);

 private:
  const Complex<D, E>& complex_;
  EngineOf<D, E>& engine_;
  bool looked_for_gaps_ = false;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
void FirstGaps<D, E>::RequestAll() {
  if (complex_.is_global()) {
    engine_.Request(kNearest, 0, NearestEpoch());
  } else if (complex_.run.has_triangulation()) {
    for (VertexIndex v = 0; v < complex_.elements.vertex_end(); ++v)
      engine_.Request(kNearest, v, NearestEpoch());
  }
}

template <int D, template <class> class E>
void FirstGaps<D, E>::FindAll() {
  if (std::exchange(looked_for_gaps_, true)) return;
  std::vector<std::uint16_t> first(complex_.elements.vertex_end(), kBuckets);
  if constexpr (D == 2) {
    const TriangleGaps<E> gaps(complex_);
    complex_.run.triangulation().ForEachSimplex([&](auto t) {
      const auto& v = complex_.run.triangulation().vertices(t);
      for (int i = 0; i < 3; ++i) {
        const VertexIndex p = v[complex_.run.triangulation().NextIndex(i)],
                          q = v[complex_.run.triangulation().PreviousIndex(i)];
        // The vertex beyond the edge is rarely needed.
        if (gaps.BucketOf(p, q, v[i], TriangulationOf<D>::kInfinite) == kBuckets) continue;
        const auto across = complex_.run.triangulation().Opposite({t, i});
        const int bucket = gaps.BucketOf(
            p, q, v[i], complex_.run.triangulation().vertices(across.simplex)[across.index]);
        auto& owners = first[complex_.IsOlder(p, q) ? q : p];
        owners = std::min(owners, static_cast<std::uint16_t>(bucket));
      }
    });
  } else {
    const TetrahedronGaps<E> gaps(complex_);
    complex_.run.triangulation().ForEachSimplex([&](auto t) {
      const auto& corners = complex_.run.triangulation().vertices(t);
      const double r2 = gaps.MostRadius2(t);
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < i; ++j) {
          const int bucket = gaps.BucketOf(corners[i], corners[j], r2);
          if (bucket == kBuckets) continue;
          const bool older = complex_.IsOlder(corners[i], corners[j]);
          auto& owners = first[corners[older ? j : i]];
          owners = std::min(owners, static_cast<std::uint16_t>(bucket));
        }
      }
    });
  }
  for (VertexIndex v = 0; v < first.size(); ++v) {
    if (first[v] < kBuckets) {
      engine_.Request(kComplete, v, MakeEpoch(first[v], 0, kQualityStep));
    }
  }
}

template <int D, template <class> class E>
void FirstGaps<D, E>::FindOf(VertexIndex v, int least) {
  int first = kBuckets;
  const auto created = complex_.run.triangulation().created();
  if constexpr (D == 2) {
    const TriangleGaps<E> gaps(complex_);
    VertexIndex right = complex_.run.triangulation().vertices(created.back())[0];
    for (const auto t : created) {
      const VertexIndex u = complex_.run.triangulation().vertices(t)[0],
                        left = complex_.run.triangulation().vertices(t)[1];
      if (u != TriangulationOf<D>::kInfinite) {
        first =
            std::min({first, gaps.BucketOf(v, u, left, right), gaps.BucketOf(u, v, right, left)});
      }
      right = u;
    }
  } else {
    const TetrahedronGaps<E> gaps(complex_);
    for (const auto t : created) {
      if (complex_.run.triangulation().IsInfinite(t)) continue;
      const auto& corners = complex_.run.triangulation().vertices(t);
      const double r2 = gaps.MostRadius2(t);
      for (int i = 0; i < 3; ++i) first = std::min(first, gaps.BucketOf(v, corners[i], r2));
    }
  }
  if (first == kBuckets) return;
  first = std::max(first, least);
  engine_.Request(kComplete, v,
                  NoEarlierThan(complex_, complex_.vertex(v).epoch, complex_.MakerOf(v), v, first));
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_FIRST_GAPS_H_
