// Anchors: the vertices that areas with a target length have from the beginning, points of a
// lattice (anchor_lattice.h). Refinement fills what is left between them and the features.
//
// Without them nothing but its neighbours would tell where a vertex of such an area goes, and an
// edit would pass on from vertex to vertex across all of it. A lattice point is an anchor if
//   a region of its level holds it,
//   no region of a finer level is nearer than kClear spacings,
//   no feature is nearer than that, nor the domain's border; facets may be half as far:
// a function of the features near it. So an edit decides those again that it may concern, and no
// other changes. Anchors stand outside the time of the trace, as the input does: an anchor is born
// with it, lies on no feature and has no owner.
#ifndef DYNMESH_CORE_MESHING_ANCHORS_H_
#define DYNMESH_CORE_MESHING_ANCHORS_H_

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/segment_distance.h"
#include "core/meshing/refinement.h"

namespace dynmesh::meshing {

// How far an anchor keeps from features and finer regions, in spacings of its lattice. What is
// left between is a seam of that width.
inline constexpr double kClear = 0.6;
// From facets, which have anchors of their own (facet_anchors.h). With 0.6 the seam had room for a
// sheet of vertices, all over which an edit passed on: 340 of 6,000 to 25,000 changed, now 12.
inline constexpr double kClearOfFacets = 0.3;

template <int D, template <class> class E>
bool Refinement<D, E>::IsAnchor(int level, double spacing, const Point& x) const {
  const double clear = kClear * spacing, clear2 = clear * clear;
  for (int k = 0; k < D; ++k) {
    if (!(rules_.lo()[k] + clear <= x[k] && x[k] <= rules_.hi()[k] - clear)) return false;
  }
  if (!AnySizeOfLevel(level, x, 0)) return false;
  if (sizing_.Any(x, clear, [&](const SizingRegion<D>& region) {
        return Lattice::LevelOf(region.target) < level && region.Meets(x, clear);
      })) {
    return false;
  }
  bool is_clear = true;
  double reach2 = clear2;
  features_.VisitNear(
      x, reach2, {features_.kNone, features_.kNone}, [](const Point&, double) { return true; },
      [&](const InputFeature<D>& f) {
        if (!(geometry::SquaredDistance(x, f.p, f.q) < clear2)) return;
        is_clear = false;
        reach2 = 0;
      });
  if constexpr (D == 3) {
    if (is_clear && !facets_.empty()) {
      facets_.ForEachNear(x, kClearOfFacets * spacing, [&](const Facet&) { is_clear = false; });
    }
  }
  return is_clear;
}

// Does a region of that level meet the ball?
template <int D, template <class> class E>
bool Refinement<D, E>::AnySizeOfLevel(int level, const Point& centre, double radius) const {
  return sizing_.Any(centre, radius, [&](const SizingRegion<D>& region) {
    return Lattice::LevelOf(region.target) == level && region.Meets(centre, radius);
  });
}

template <int D, template <class> class E>
void Refinement<D, E>::AddSize(const SizingRegion<D>& region) {
  ++levels_[Lattice::LevelOf(region.target)];
  changed_sizes_.push_back(region);
  IndexFeatures();
}

template <int D, template <class> class E>
void Refinement<D, E>::RemoveSize(const SizingRegion<D>& region) {
  const auto level = levels_.find(Lattice::LevelOf(region.target));
  if (--level->second == 0) levels_.erase(level);
  changed_sizes_.push_back(region);
}

// Decides those again that what has changed since the last propagation may concern. False if it
// was interrupted: then the rest is still to be decided.
template <int D, template <class> class E>
bool Refinement<D, E>::UpdateAnchors(absl::FunctionRef<bool()> interrupt) {
  int decided = 0;
  const auto decide = [&](int level, const Lattice& lattice, const typename Lattice::Index& index,
                          const Point& x) {
    DecideAnchor(level, lattice, index, x);
    return (++decided & 255) != 0 || !interrupt();
  };
  // Calls decide for points of `level` in the box that the ball around may_be_near may concern.
  const auto decide_in = [&](int level, const Extent<D>& box, bool everywhere, auto is_near) {
    const Lattice lattice(level);
    const double clear = kClear * lattice.spacing();
    Extent<D> within;
    for (int k = 0; k < D; ++k) {
      within.lo[k] = std::max(box.lo[k] - clear, rules_.lo()[k]);
      within.hi[k] = std::min(box.hi[k] + clear, rules_.hi()[k]);
    }
    return lattice.ForEachIn(
        within,
        [&](const Point& centre, double radius) {
          return is_near(centre, radius + clear) &&
                 (everywhere || AnySizeOfLevel(level, centre, radius));
        },
        [&](const typename Lattice::Index& index, const Point& x) {
          return decide(level, lattice, index, x);
        });
  };
  for (const SizingRegion<D>& region : changed_sizes_) {
    Extent<D> box = Extent<D>::Nothing();
    box.AddBall(region.lo, region.radius);
    box.AddBall(region.hi, region.radius);
    const auto is_near = [&](const Point& centre, double radius) {
      return region.Meets(centre, radius);
    };
    const int own = Lattice::LevelOf(region.target);
    if (!decide_in(own, box, true, is_near)) return false;
    for (auto level = levels_.upper_bound(own); level != levels_.end(); ++level) {
      if (!decide_in(level->first, box, false, is_near)) return false;
    }
  }
  // Where there was no size before, all has been decided by now.
  const bool had_sizes = std::exchange(had_sizes_, !levels_.empty());
  for (const auto& [level, count] : levels_) {
    if (!had_sizes) break;
    for (const auto& change : changed_features_) {
      const InputFeature<D>& f = change.first;
      const auto is_near = [&](const Point& centre, double radius) {
        return geometry::SquaredDistance(centre, f.p, f.q) <= radius * radius;
      };
      if (!decide_in(level, BoxOf(f), false, is_near)) return false;
    }
    if constexpr (D == 3) {
      for (const Facet& facet : changed_facets_) {
        const auto is_near = [&](const Point& centre, double radius) {
          return facet.where().MayMeet(centre, radius);
        };
        if (!decide_in(level, facet.where().box, false, is_near)) return false;
      }
    }
  }
  if (!UpdateFacetAnchors(interrupt)) return false;
  changed_sizes_.clear();
  return true;
}

template <int D, template <class> class E>
void Refinement<D, E>::DecideAnchor(int level, const Lattice& lattice,
                                    const typename Lattice::Index& index, const Point& x) {
  const bool is = IsAnchor(level, lattice.spacing(), x);
  const auto at = anchors_.find({level, index});
  if (is == (at != anchors_.end())) return;
  if (is) {
    anchors_[{level, index}] = AddAnchor(x);
  } else if constexpr (kTraced) {
    RemoveAnchor(at->second);
    anchors_.erase(at);
  }
}

template <int D, template <class> class E>
void Refinement<D, E>::RemoveAnchor(VertexIndex v) {
  if constexpr (kTraced) {
    engine_.Unrequest(kNearest, v, NearestEpoch());
    WithdrawVertex(v, engine_.beginning());
    released_vertices_.push_back(v);
  }
}

template <int D, template <class> class E>
VertexIndex Refinement<D, E>::AddAnchor(const Point& p) {
  const VertexIndex v = AddPoint(p, kNil);
  vertices_[v].dimension = D;
  return v;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_ANCHORS_H_
