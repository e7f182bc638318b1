// Notifications: visits the operations that may have read what changed, and marks stale those that
// the filters (read_filter.h) do not exclude.
#ifndef DYNMESH_CORE_MESHING_NOTIFIER_H_
#define DYNMESH_CORE_MESHING_NOTIFIER_H_

#include <algorithm>
#include <cmath>
#include <span>

#include "absl/container/flat_hash_set.h"
#include "core/base/rounding.h"
#include "core/geometry/segment_distance.h"
#include "core/meshing/complex.h"
#include "core/meshing/encroachment.h"
#include "core/meshing/feature_changes.h"
#include "core/meshing/read_filter.h"
#include "core/meshing/size_changes.h"

namespace dynmesh::meshing {

// Untraced it does nothing. Thread-compatible.
template <int D, template <class> class E>
class Notifier {
 public:
  using Point = geometry::Point<D>;
  using Subsegment = meshing::Subsegment<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;

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
  void OfSizes(const SizeChanges<D>& changes);
  // Facets close together have nearly the same readers: an operation that read nothing in the box
  // around a group is tested only once. (An operation that read a vertex removed since then is
  // stale and is not tested.)
  void OfFacets(std::span<const Facet> changed);

  // Cells visited because of sizes so far.
  std::uint64_t visited_cells() const { return visited_cells_; }

 private:
  // An operation subscribes in cells at least half as large as the box of what it read
  // (SpatialTree::Cover). So cells smaller than the balls that the region allows have no subscriber
  // to notify. Nor does a cell in which the change is hidden: of a ball that meets the region, and
  // no other one as fine, a point in the region is outside of those others, and so is the cell
  // with this point, to which the operation subscribes.
  void OfSizes(const SizeChanges<D>& changes, const typename SizeChanges<D>::Group& group);
  // Notifies of a change of state outside the time of the trace, which holds from the beginning.
  // Visits the operations that read in cells that meet the box and for which keep(centre, half the
  // side) is true. Marks stale those for which matters(operation) is true.
  template <class Keep, class Matters>
  void FromBeginning(const Extent<D>& box, Keep keep, Matters matters);
  void OfFacetsIn(const Extent<3>& box, std::span<const Facet> facets);

  const Complex<D, E>& complex_;
  EngineOf<D, E>& engine_;
  ReadFilter<D, E> filter_;
  absl::flat_hash_set<sac::OpId> examined_;  // scratch
  std::uint64_t visited_cells_ = 0;
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
    complex_.tree.VisitBoxIf(
        box, keep, [&](sac::Place place) { engine_.NotifyFromBeginning(place, matters); });
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
void Notifier<D, E>::OfSizes(const SizeChanges<D>& changes) {
  if constexpr (!kTraced) return;
  if (!engine_.AnyAfter(engine_.beginning())) return;
  for (auto group : changes.groups()) {
    const auto is_hidden = [&](const auto* change) {
      return changes.IsHidden(*change, [](const SizingRegion<D>&) { return true; });
    };
    group.erase(std::remove_if(group.begin(), group.end(), is_hidden), group.end());
    if (!group.empty()) OfSizes(changes, group);
  }
}

// An operation subscribes to several cells, and only a few have balls as large as to matter: these
// are examined once.
template <int D, template <class> class E>
void Notifier<D, E>::OfSizes(const SizeChanges<D>& changes,
                             const typename SizeChanges<D>::Group& group) {
  Extent<D> box = Extent<D>::Nothing();
  double least_radius = INFINITY;
  for (const auto* change : group) {
    const Extent<D> of_region = change->region.Box();
    box.AddBall({of_region.lo}, 0);
    box.AddBall({of_region.hi}, 0);
    least_radius = std::min(least_radius, change->region.most_radius());
  }
  const double least_half = least_radius * kNarrower - complex_.rules.ulp();
  examined_.clear();
  FromBeginning(
      box,
      [&](const Point& centre, double half) {
        if (half < least_half) return false;
        ++visited_cells_;
        Extent<D> cell = Extent<D>::Nothing();
        cell.AddBall(centre, half);
        return std::ranges::any_of(group, [&](const auto* change) {
          return change->region.MayMeet(cell) && !changes.IsHidden(*change, cell);
        });
      },
      [&](sac::OpId op) {
        return filter_.MayHaveJudged(op, least_radius) && examined_.insert(op).second &&
               filter_.SizesMatter(op, changes, group);
      });
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
