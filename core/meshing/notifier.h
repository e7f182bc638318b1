// Notifications: visits the operations that may have read what changed, and marks stale those that
// the filters (read_filter.h) do not exclude.
#ifndef DYNMESH_CORE_MESHING_NOTIFIER_H_
#define DYNMESH_CORE_MESHING_NOTIFIER_H_

#include <algorithm>
#include <cmath>
#include <span>

#include "core/base/rounding.h"
#include "core/geometry/segment_distance.h"
#include "core/meshing/complex.h"
#include "core/meshing/encroachment.h"
#include "core/meshing/feature_changes.h"
#include "core/meshing/read_filter.h"

namespace dynmesh::meshing {

// Untraced it does nothing. Thread-compatible.
template <int D, template <class> class E>
class Notifier {
 public:
  using Point = geometry::Point<D>;
  using Subsegment = meshing::Subsegment<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;
  // Distances from a shape are off by a few ulps: for a cell, and for a ball that was read.
  static constexpr double kUlpsOfShapes = 16;

  Notifier(const Complex<D, E>& complex, EngineOf<D, E>& engine)
      : complex_(complex), engine_(engine), filter_(complex, engine) {}

  // v appears or vanishes at time `at`.
  void OfVertex(VertexIndex v, bool appears, sac::Stamp at);
  // If s is exposed, notifies operations with a time in (after, until]: those that made a vertex in
  // its ball, and those that yielded or were kept out, perhaps because of it. Most operations did
  // neither and are not visited.
  void OfSubsegment(SubsegmentIndex s, sac::Stamp after, sac::Stamp until);
  // Changes of input, which hold from the beginning.
  void OfFeatures(const FeatureChanges<D>& changes);
  // An operation subscribes in cells at least half as large as the box of what it read
  // (SpatialTree::Cover). So cells smaller than the balls that the region allows have no subscriber
  // to notify.
  void OfSizing(const SizingRegion<D>& region);
  // Facets close together have nearly the same readers: an operation that read nothing in the box
  // around a group is tested only once. (An operation that read a vertex removed since then is
  // stale and is not tested.)
  void OfFacets(std::span<const Facet> changed);

 private:
  // Notifies of a change of state outside the time of the trace, which holds from the beginning.
  // Visits the operations that read in cells that meet the box and for which keep(centre, half the
  // side) is true. Marks stale those for which matters(operation) is true.
  template <class Keep, class Matters>
  void FromBeginning(const Extent<D>& box, Keep keep, Matters matters);
  void OfFacetsIn(const Extent<3>& box, std::span<const Facet> facets);

  const Complex<D, E>& complex_;
  EngineOf<D, E>& engine_;
  ReadFilter<D, E> filter_;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
void Notifier<D, E>::OfVertex(VertexIndex v, bool appears, sac::Stamp at) {
  if constexpr (kTraced) {
    if (!engine_.AnyAfter(at)) return;
    complex_.tree.VisitPath(complex_.vertex(v).p, [&](sac::Place place, sac::Parts part) {
      engine_.Notify(place, part, at, sac::kNoStamp,
                     [&](sac::OpId op) { return filter_.VertexMatters(op, v, appears); });
    });
  }
}

template <int D, template <class> class E>
void Notifier<D, E>::OfSubsegment(SubsegmentIndex i, sac::Stamp after, sac::Stamp until) {
  if constexpr (kTraced) {
    const Subsegment& s = complex_.subsegment(i);
    if (s.exposed == sac::kNoStamp || !engine_.AnyAfter(after)) return;
    const Point &a = complex_.vertex(s.a).p, &b = complex_.vertex(s.b).p;
    const Point middle = geometry::Midpoint(a, b);
    const double radius = complex_.RadiusOf(s);
    double r2 = radius * radius;
    const auto notify_maker = [&](std::uint32_t x, const Point& p, double) {
      const sac::OpId maker = complex_.vertex(x).creator;
      if (maker == sac::kNoOp || x == s.a || x == s.b) return;
      engine_.NotifyOperation(maker, after, until, [&](sac::OpId op) {
        return filter_.BallOverOutputMatters(op, a, b, p);
      });
    };
    complex_.tree.VisitBall(middle, r2, notify_maker);
    if (complex_.slivers.is_on()) complex_.cured.VisitBall(middle, r2, notify_maker);
    complex_.tree.VisitCells({middle, r2}, [&](sac::Place place) {
      engine_.NotifyAttentive(place, after, until, [&](sac::OpId op) {
        return filter_.BallMatters(op, middle, radius);
      });
    });
  }
}

template <int D, template <class> class E>
template <class Keep, class Matters>
void Notifier<D, E>::FromBeginning(const Extent<D>& box, Keep keep, Matters matters) {
  if constexpr (kTraced) {
    if (!engine_.AnyAfter(engine_.beginning())) return;
    complex_.tree.VisitBoxIf(box, keep, [&](sac::Place place) {
      engine_.Notify(place, engine_.beginning(), sac::kNoStamp, matters);
    });
  }
}

template <int D, template <class> class E>
void Notifier<D, E>::OfFeatures(const FeatureChanges<D>& changes) {
  for (const auto& [f, came] : changes) {
    FromBeginning(
        BoxOf(f),
        [&f = f](const Point& centre, double half) {
          return geometry::MayMeetCube(centre, half * kBarelyWider, f.p, f.q);
        },
        [this, &f = f, came = came](sac::OpId op) { return filter_.FeatureMatters(op, f, came); });
  }
}

template <int D, template <class> class E>
void Notifier<D, E>::OfSizing(const SizingRegion<D>& region) {
  Extent<D> box = Extent<D>::Nothing();
  box.AddBall(region.lo, region.radius);
  box.AddBall(region.hi, region.radius);
  const double least_half = region.most_radius() * kNarrower - complex_.rules.ulp();
  const double rounding = kUlpsOfShapes * complex_.rules.ulp();
  FromBeginning(
      box,
      [&](const Point& centre, double half) {
        // A shape may leave most of its box free.
        return half >= least_half &&
               (region.shape == nullptr ||
                region.Meets(centre, half * kCornerOfCube<D> * kBarelyWider + rounding));
      },
      [&](sac::OpId op) { return filter_.SizingMatters(op, region); });
}

template <int D, template <class> class E>
void Notifier<D, E>::OfFacets(std::span<const Facet> changed) {
  if constexpr (!kTraced) return;
  const auto size = [](const Extent<3>& box) {
    return std::max({box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2]});
  };
  for (std::size_t begin = 0, end = 0; begin < changed.size(); begin = end) {
    Extent<3> group = changed[begin].where().box;
    double largest = size(group);
    for (end = begin + 1; end < changed.size(); ++end) {
      const Extent<3>& next = changed[end].where().box;
      Extent<3> all = group;
      all.AddBall({next.lo}, 0);
      all.AddBall({next.hi}, 0);
      largest = std::max(largest, size(next));
      if (size(all) > 2 * largest) break;
      group = all;
    }
    OfFacetsIn(group, changed.subspan(begin, end - begin));
  }
}

template <int D, template <class> class E>
void Notifier<D, E>::OfFacetsIn(const Extent<3>& box, std::span<const Facet> facets) {
  if constexpr (kTraced && D == 3) {
    FromBeginning(
        box,
        [&](const Point& centre, double half) {
          return std::ranges::any_of(facets, [&](const Facet& facet) {
            return facet.where().MayMeet(centre, kCornerOfCube<3> * half);
          });
        },
        [&](sac::OpId op) {
          return filter_.BoxMatters(op, box) &&
                 std::ranges::any_of(
                     facets, [&](const Facet& facet) { return filter_.FacetMatters(op, facet); });
        });
  }
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_NOTIFIER_H_
