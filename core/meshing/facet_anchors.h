// Anchors of facets: vertices that a facet has from the beginning, where a disjoint feature is near
// it or a target length applies. They are points of the facet's lattice (facet_lattice.h).
//
// Between two facets the position of a vertex would otherwise depend on neighbours alone, and an
// edit would propagate all over the facets. Let d be the distance of a point x from the nearest
// feature disjoint from the facet, h the target at x, and w as in FacetSpacing. x, a point of level
// k, is an anchor if
//   the spacing of level k - 1 is too wide at x: more than min(w d, 0.8 h),
//   all edges of the facet are farther than min(d, kClearOfEdges h), and
//   x is inside the facet.
// So spacings are between w d / sqrt 2 and w d, as wide as the quality bound allows, or between
// 0.8 h / sqrt 2 and 0.8 h. This is a function of the features near x. So an edit decides again
// only the points that it may affect. Like other anchors these stand outside the time of the trace
// (anchors.h). They are on their facet as if refinement had put them there.
//
// For a new facet the features that may matter are found once. On the way down to small cells each
// cell keeps those that may matter in it: a few, where the search from above, for each point, would
// visit whatever is near, on the facet or not. After other changes few cells are decided again, and
// features are searched for.
#ifndef DYNMESH_CORE_MESHING_FACET_ANCHORS_H_
#define DYNMESH_CORE_MESHING_FACET_ANCHORS_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/functional/function_ref.h"
#include "core/base/rings.h"
#include "core/base/rounding.h"
#include "core/geometry/segment_distance.h"
#include "core/meshing/complex.h"
#include "core/meshing/facet_lattice.h"
#include "core/meshing/input_editor.h"

namespace dynmesh::meshing {

// The widest spacing that leaves no room for vertices between the facet and a lattice beside it.
inline constexpr double kSpacingInTargets = 0.8;
// In targets. Subsegments of edges are shorter than twice that (IsTooLong), so their balls hold no
// anchor.
inline constexpr double kClearOfEdges = 0.66;

// True if none of the feature's ends is a corner of the facet.
template <int D>
bool AreDisjoint(const Facet& facet, const InputFeature<D>& f) {
  return !facet.HasCorner(f.a) && !facet.HasCorner(f.b);
}
inline bool AreDisjoint(std::span<const VertexIndex> corners, std::span<const VertexIndex> others) {
  if (corners.size() > others.size()) std::swap(corners, others);
  return std::ranges::none_of(corners,
                              [&](VertexIndex v) { return std::ranges::binary_search(others, v); });
}

template <int D, template <class> class E>
class FacetAnchors {
 public:
  using Point = geometry::Point<D>;

  FacetAnchors(const Complex<D, E>& complex, InputEditor<D, E>& input)
      : complex_(complex), input_(input) {}

  // Decides again the anchors that changes since the last propagation may affect. False if it was
  // interrupted: then the rest remains to be decided.
  bool Update(absl::FunctionRef<bool()> interrupt);
  // How many lattice points were decided so far, and of how many features and facets distances were
  // taken.
  std::uint64_t decided() const { return decided_; }
  std::uint64_t looked_at() const { return looked_at_; }
  // Removes the facet's anchors.
  void Remove(FacetIndex facet);

 private:
  struct FacetIsNew {
    double operator()(const Point&, double) const { return INFINITY; }
  };
  struct Surroundings {
    double feature, edge;  // distances
  };
  // What may matter on a facet, or in a cell of its lattice.
  struct Known {
    struct Feature {
      Point p, q;
      bool is_edge;  // of the facet; others are disjoint from it
    };
    std::vector<Feature> features;
    std::vector<const Facet*> facets;  // disjoint from it
  };
  double Spacing() const;
  // `known`: has what matters at x; if null, it is searched for.
  Surroundings Around(const Facet& facet, const Point& x, double radius, double margin,
                      const Known* known) const;
  Known KnownOf(const Facet& facet) const;
  // What of it is within that distance of x.
  Known Within(const Known& known, const Point& x, double distance) const;
  bool MayHaveAnchors(const Facet& facet) const;
  // So few need not be fewer in smaller cells.
  static constexpr std::size_t kFewKnown = 8;
  static bool IsWithinReach(const Facet& facet, const InputFeature<D>& f);
  static bool HasCornerOver(const Facet& facet, const Facet& other);
  static bool IsWithinReach(const Facet& facet, const Facet& other);
  bool HasEdgeWithin(const Facet& facet, const Point& x, double radius, const Known* known) const;
  bool IsAnchor(const Facet& facet, const FacetLattice& lattice, int level, const Point& x,
                const Known* known) const;
  template <class FeatureChanged, class SizeChanged, class F>
  bool VisitLattice(const Facet& facet, const FacetLattice& lattice, const FacetLattice::Cell& cell,
                    const FeatureChanged& feature_changed, const SizeChanged& size_changed,
                    const Known* known, F decide) const;
  template <class FeatureChanged, class SizeChanged>
  bool Decide(FacetIndex i, const FeatureChanged& feature_changed, const SizeChanged& size_changed,
              absl::FunctionRef<bool()> interrupt);
  void DecideAnchor(FacetIndex facet, const FacetLattice::Index& index, const Point& x, bool is);

  const Complex<D, E>& complex_;
  InputEditor<D, E>& input_;
  absl::flat_hash_map<FacetIndex, absl::flat_hash_map<FacetLattice::Index, VertexIndex>> anchors_;
  std::uint64_t decided_ = 0;
  mutable std::uint64_t looked_at_ = 0;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
void FacetAnchors<D, E>::Remove(FacetIndex facet) {
  const auto anchors = anchors_.find(facet);
  if (anchors == anchors_.end()) return;
  for (const auto& [index, v] : anchors->second) input_.RemovePoint(v);
  anchors_.erase(anchors);
}

// w. Take two facets at distance 1, and on each a square of side w, one above the other. The ball
// through the eight corners has R^2 = (2 w^2 + 1) / 4 < min(rho, 2)^2.
template <int D, template <class> class E>
double FacetAnchors<D, E>::Spacing() const {
  const double rho = std::min(complex_.rules.quality(), 2.0);
  return 0.95 * std::sqrt(2 * rho * rho - 0.5);
}

// The distances from a point x on the facet to the nearest feature disjoint from the facet, and to
// the facet's nearest edge; each at most `radius`. Features farther than the nearest edge +
// `margin` count as that far. The result depends neither on the order in which features are found
// nor on how many are equally near.
template <int D, template <class> class E>
typename FacetAnchors<D, E>::Surroundings FacetAnchors<D, E>::Around(const Facet& facet,
                                                                     const Point& x, double radius,
                                                                     double margin,
                                                                     const Known* known) const {
  Surroundings near{radius, radius};
  if constexpr (D == 3) {
    const double all2 = radius * radius;
    const auto nearest = [&](double feature2, double edge2) {
      near.edge = std::sqrt(edge2);
      near.feature = std::min({radius, std::sqrt(feature2), near.edge + margin});
    };
    if (known != nullptr) {
      looked_at_ += known->features.size() + known->facets.size();
      double feature2 = all2, edge2 = all2;
      for (const auto& [p, q, is_edge] : known->features) {
        double& least = is_edge ? edge2 : feature2;
        least = std::min(least, geometry::SquaredDistance(x, p, q));
      }
      nearest(feature2, edge2);
      for (const Facet* other : known->facets) {
        if (other->where().MayMeet(x, near.feature) && other->IsOver(x, near.feature)) {
          near.feature = std::fabs(other->plane().Height(x));
        }
      }
      return near;
    }
    double feature2 = all2, edge2 = all2, within2 = all2;
    complex_.features.VisitNear(
        x, within2, {complex_.features.kNone, complex_.features.kNone},
        [](const Point&, double) { return true; },
        [&](const InputFeature<D>& f) {
          ++looked_at_;
          const double d2 = geometry::SquaredDistance(x, f.p, f.q);
          if (!(d2 < within2)) return;
          if (AreDisjoint(facet, f)) {
            feature2 = std::min(feature2, d2);
          } else if (facet.HasEdge(f.a, f.b)) {
            edge2 = std::min(edge2, d2);
          } else {
            return;
          }
          // Features at exactly this distance are visited, too.
          const double of_edge = std::sqrt(edge2) + margin;
          within2 = std::min(all2, std::min(feature2, of_edge * of_edge) * kBarelyWider);
        });
    nearest(feature2, edge2);
    // Corners are features, so few facets are nearer than the nearest feature.
    complex_.facets.ForEachNear(x, near.feature, [&](const Facet& other) {
      if (other.IsOver(x, near.feature) && AreDisjoint(facet.corners(), other.corners())) {
        near.feature = std::fabs(other.plane().Height(x));
      }
    });
  }
  return near;
}

// What is within reach of the facet.
template <int D, template <class> class E>
typename FacetAnchors<D, E>::Known FacetAnchors<D, E>::KnownOf(const Facet& facet) const {
  Known known;
  if constexpr (D == 3) {
    const double reach = facet.reach() * kWider + 4 * complex_.rules.ulp();
    const FacetExtent& where = facet.where();
    const auto [middle, radius] = where.BallAround(reach);
    absl::flat_hash_set<std::pair<VertexIndex, VertexIndex>> seen;
    complex_.features.VisitNear(
        middle, radius * radius, {complex_.features.kNone, complex_.features.kNone},
        [&](const Point& centre, double half) {
          return where.MayMeet(centre, kCornerOfCube<3> * half * kBarelyWider + reach);
        },
        [&](const InputFeature<D>& f) {
          const bool is_edge = facet.HasEdge(f.a, f.b);
          if (!is_edge && !AreDisjoint(facet, f)) return;
          if (seen.emplace(f.a, f.b).second) known.features.push_back({f.p, f.q, is_edge});
        });
    complex_.facets.ForEachNear(middle, radius, [&](const Facet& other) {
      if (where.AreWithin(other.where(), reach) && AreDisjoint(facet.corners(), other.corners())) {
        known.facets.push_back(&other);
      }
    });
  }
  return known;
}

template <int D, template <class> class E>
typename FacetAnchors<D, E>::Known FacetAnchors<D, E>::Within(const Known& known, const Point& x,
                                                              double distance) const {
  Known within;
  if constexpr (D == 3) {
    looked_at_ += known.features.size() + known.facets.size();
    for (const auto& f : known.features) {
      const bool is = geometry::SquaredDistance(x, f.p, f.q) < distance * distance;
      if (is) within.features.push_back(f);
    }
    for (const Facet* facet : known.facets) {
      if (facet->where().MayMeet(x, distance)) within.facets.push_back(facet);
    }
  }
  return within;
}

template <int D, template <class> class E>
bool FacetAnchors<D, E>::IsAnchor(const Facet& facet, const FacetLattice& lattice, int level,
                                  const Point& x, const Known* known) const {
  if constexpr (D == 3) {
    const double wider = lattice.Spacing(level - 1), target = complex_.sizing.LeastTarget(x, 0),
                 clear = kClearOfEdges * target;
    const double radius = std::min(facet.reach(), std::max(wider / Spacing(), clear * kWider));
    const auto [feature, edge] = Around(facet, x, radius, 0, known);
    const bool for_feature = feature < std::min(edge, radius) && wider > Spacing() * feature,
               for_target = wider > kSpacingInTargets * target && edge > std::min(feature, clear);
    return (for_feature || for_target) &&
           feature * feature > 64 * complex_.rules.least_squared_length() && facet.IsInside(x);
  }
  return false;
}

// May feature f, disjoint from the facet, be near enough to cause anchors? Conservative: may return
// true needlessly.
template <int D, template <class> class E>
bool FacetAnchors<D, E>::IsWithinReach(const Facet& facet, const InputFeature<D>& f) {
  if constexpr (D == 3) {
    const double reach = facet.reach();
    bool is = facet.IsOver(f.p, reach) || facet.IsOver(f.q, reach);
    ForEachEdgeOf(facet.rings(), [&](const Point& p, const Point& q) {
      is = is || geometry::SquaredDistance(p, q, f.p, f.q) < reach * reach;
    });
    return is;
  }
  return false;
}

// True if `facet` has a corner over `other`, within facet's reach.
template <int D, template <class> class E>
bool FacetAnchors<D, E>::HasCornerOver(const Facet& facet, const Facet& other) {
  if constexpr (D == 3) {
    for (const geometry::Ring3& ring : facet.rings()) {
      for (const Point& p : ring) {
        if (other.IsOver(p, facet.reach())) return true;
      }
    }
  }
  return false;
}

template <int D, template <class> class E>
bool FacetAnchors<D, E>::IsWithinReach(const Facet& facet, const Facet& other) {
  if constexpr (D == 3) {
    constexpr std::size_t kMany = 4096;  // testing more pairs takes longer than it saves
    if (facet.corners().size() * other.corners().size() > kMany) return true;
    bool is = HasCornerOver(facet, other);
    ForEachEdgeOf(other.rings(), [&](const Point& p, const Point& q) {
      is = is || IsWithinReach(facet, InputFeature<D>{kNil, kNil, p, q});
    });
    return is;
  }
  return false;
}

// Most facets of a surface have no anchors. Conservative: may return true needlessly.
template <int D, template <class> class E>
bool FacetAnchors<D, E>::MayHaveAnchors(const Facet& facet) const {
  if constexpr (D == 3) {
    constexpr std::size_t kManyCorners = 32;
    if (facet.corners().size() > kManyCorners) return true;
    const double reach = facet.reach() * kWider;
    const FacetExtent& where = facet.where();
    const auto [middle, radius] = where.BallAround(reach);
    bool may = complex_.sizing.LeastTarget(middle, radius) < INFINITY;
    complex_.features.VisitNear(
        middle, radius * radius, {complex_.features.kNone, complex_.features.kNone},
        [&](const Point& centre, double half) {
          return !may && where.MayMeet(centre, kCornerOfCube<3> * half + reach);
        },
        [&](const InputFeature<D>& f) {
          may = may || (AreDisjoint(facet, f) && IsWithinReach(facet, f));
        });
    // Edges of other facets are features. What remains is a corner over the inside of another
    // facet.
    return may || complex_.facets.AnyNear(middle, radius, kNothingHidden, [&](const Facet& other) {
      return where.AreWithin(other.where(), reach) && HasCornerOver(facet, other) &&
             AreDisjoint(facet.corners(), other.corners());
    });
  }
  return false;
}

template <int D, template <class> class E>
bool FacetAnchors<D, E>::HasEdgeWithin(const Facet& facet, const Point& x, double radius,
                                       const Known* known) const {
  double within2 = radius * radius;
  if (known != nullptr) {
    looked_at_ += known->features.size();
    return std::ranges::any_of(known->features, [&](const auto& f) {
      return f.is_edge && geometry::SquaredDistance(x, f.p, f.q) < within2;
    });
  }
  bool has = false;
  complex_.features.VisitNear(
      x, within2, {complex_.features.kNone, complex_.features.kNone},
      [](const Point&, double) { return true; },
      [&](const InputFeature<D>& f) {
        ++looked_at_;
        if (has || !(geometry::SquaredDistance(x, f.p, f.q) < within2)) return;
        has = facet.HasEdge(f.a, f.b);
        if (has) within2 = 0;
      });
  return has;
}

// Calls decide(index, point, known there) until it returns false, for the points of the cell that
// may be anchors, or may have been before a change. Returns false if decide did. The change: a
// feature at distance feature_changed(x) from x, or sizes, where size_changed(x, radius) is the
// least changed target in that ball. INFINITY: no such change. FacetIsNew in place of size_changed:
// all points are decided. Conservative.
template <int D, template <class> class E>
template <class FeatureChanged, class SizeChanged, class F>
bool FacetAnchors<D, E>::VisitLattice(const Facet& facet, const FacetLattice& lattice,
                                      const FacetLattice::Cell& cell,
                                      const FeatureChanged& feature_changed,
                                      const SizeChanged& size_changed, const Known* known,
                                      F decide) const {
  const Point middle = lattice.MiddleOf(cell);
  const double radius = lattice.RadiusOf(cell) + 4 * complex_.rules.ulp(), reach = facet.reach(),
               changed_feature = feature_changed(middle),
               changed_target = size_changed(middle, radius);
  const auto [feature, edge] = Around(facet, middle, radius + reach, 2 * radius * kWider, known);
  // If another feature is nearer everywhere in the cell, the changed one has no effect.
  const bool is_concerned = changed_target < INFINITY || changed_feature <= feature + 2 * radius;
  if (!is_concerned && !std::is_same_v<SizeChanged, FacetIsNew>) return true;
  const double least = std::min(feature, changed_feature) - radius,  // distance of disjoint
                                                                     // features
      target = std::min(complex_.sizing.LeastTarget(middle, radius), changed_target),
               clear = std::min(least, kClearOfEdges * target);
  if (!(clear < reach)) return true;
  if (facet.IsInside(middle)) {
    if (std::min(edge + radius, reach) < clear) return true;  // an edge is nearer everywhere
  } else if (!HasEdgeWithin(facet, middle, radius, known)) {
    return true;  // the cell holds nothing of the facet
  }
  // Let d be `feature`: of the nearest disjoint feature, or of an edge and 2 radius. At a place in
  // the cell either is at most d + radius away. What is nearer there is within d + 2 radius of the
  // middle.
  Known in_cell;
  if (known != nullptr && known->features.size() + known->facets.size() > kFewKnown) {
    in_cell = Within(*known, middle, (feature + 2 * radius) * kWider + 4 * complex_.rules.ulp());
    known = &in_cell;
  }
  if (clear > 0) {
    constexpr double kFew = 4;  // along a side
    const double least_spacing = std::min(Spacing() * least, kSpacingInTargets * target);
    const int finest = lattice.LevelOf(least_spacing * kBarelyNarrower);
    if (kFew * lattice.Spacing(finest) >= cell.side()) {
      return lattice.ForEachIn(cell, finest, [&](const FacetLattice::Index& index, const Point& x) {
        return decide(index, x, known);
      });
    }
  }
  if (radius * radius < 64 * complex_.rules.least_squared_length()) return true;
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    if (!VisitLattice(facet, lattice, FacetLattice::Child(cell, quadrant), feature_changed,
                      size_changed, known, decide)) {
      return false;
    }
  }
  return true;
}

// Decides the facet's anchors again, as VisitLattice does. False if it was interrupted.
template <int D, template <class> class E>
template <class FeatureChanged, class SizeChanged>
bool FacetAnchors<D, E>::Decide(FacetIndex i, const FeatureChanged& feature_changed,
                                const SizeChanged& size_changed,
                                absl::FunctionRef<bool()> interrupt) {
  const Facet& facet = complex_.facets[i];
  const FacetLattice lattice(facet.plane());
  const Extent<3>& box = facet.where().box;
  std::optional<Known> known;
  if constexpr (std::is_same_v<SizeChanged, FacetIsNew>) known = KnownOf(facet);
  return lattice.ForEachCellOver({box.lo}, {box.hi}, [&](const FacetLattice::Cell& cell) {
    return VisitLattice(facet, lattice, cell, feature_changed, size_changed,
                        known ? &*known : nullptr,
                        [&](const FacetLattice::Index& index, const Point& x, const Known* near) {
                          const bool is = IsAnchor(facet, lattice, index.level, x, near);
                          DecideAnchor(i, index, x, is);
                          return !interrupt();
                        });
  });
}

template <int D, template <class> class E>
void FacetAnchors<D, E>::DecideAnchor(FacetIndex facet, const FacetLattice::Index& index,
                                      const Point& x, bool is) {
  ++decided_;
  const auto of_facet = anchors_.find(facet);
  const bool was = of_facet != anchors_.end() && of_facet->second.contains(index);
  if (is == was) return;
  if (is) {
    anchors_[facet][index] = input_.AddAnchor(x, complex_.facets[facet].feature());
  } else {
    const auto at = of_facet->second.find(index);
    input_.RemovePoint(at->second);
    of_facet->second.erase(at);
    if (of_facet->second.empty()) anchors_.erase(of_facet);
  }
}

template <int D, template <class> class E>
bool FacetAnchors<D, E>::Update(absl::FunctionRef<bool()> interrupt) {
  if constexpr (D == 3) {
    if (complex_.facets.empty()) return true;
    const auto& changes = input_.changes();
    int decided = 0;
    const auto sometimes = [&] { return (++decided & 255) == 0 && interrupt(); };
    const auto is_new = [&](FacetIndex i) {
      return std::ranges::find(changes.new_facets, i) != changes.new_facets.end();
    };
    constexpr auto kNoFeature = [](const Point&) { return INFINITY; };
    constexpr auto kNoSize = [](const Point&, double) { return INFINITY; };
    for (const FacetIndex i : changes.new_facets) {
      if (!MayHaveAnchors(complex_.facets[i])) continue;
      if (!Decide(i, kNoFeature, FacetIsNew(), sometimes)) return false;
    }
    if (changes.new_facets.size() < complex_.facets.size()) {
      for (const auto& change : changes.features) {
        const InputFeature<D>& f = change.first;
        const auto distance = [&](const Point& x) {
          return std::sqrt(geometry::SquaredDistance(x, f.p, f.q));
        };
        for (const FacetIndex i : complex_.facets.Reaching(BoxOf(f), distance)) {
          const Facet& facet = complex_.facets[i];
          if (is_new(i) || !AreDisjoint(facet, f) || !IsWithinReach(facet, f)) continue;
          if (!Decide(i, distance, kNoSize, sometimes)) return false;
        }
      }
      for (const Facet& changed : changes.facets) {
        const auto least = [&](const Point& x) { return changed.where().LeastDistance(x); };
        const auto distance = [&](const Point& x) { return changed.Distance(x); };
        for (const FacetIndex i : complex_.facets.Reaching(changed.where().box, least)) {
          const Facet& facet = complex_.facets[i];
          if (is_new(i) || !AreDisjoint(facet.corners(), changed.corners()) ||
              !IsWithinReach(facet, changed)) {
            continue;
          }
          if (!Decide(i, distance, kNoSize, sometimes)) return false;
        }
      }
      for (const auto& change : changes.sizes.list()) {
        const SizingRegion<D>& region = change.region;
        const auto target = [&](const Point& x, double radius) {
          const bool counts = region.Meets(x, radius) && !changes.sizes.IsHidden(change, x, radius);
          return counts ? region.target : INFINITY;
        };
        const Point middle = geometry::Midpoint(region.lo, region.hi);
        const double radius =
            region.radius + 0.5 * std::sqrt(geometry::SquaredDistance(region.lo, region.hi));
        std::vector<FacetIndex> met;
        complex_.facets.ForEachNear(middle, radius * kBarelyWider, [&](const Facet& facet) {
          met.push_back(complex_.facets.OfFeature(facet.feature()));
        });
        for (const FacetIndex i : met) {
          if (is_new(i)) continue;
          if (!Decide(i, kNoFeature, target, sometimes)) return false;
        }
      }
    }
  }
  return true;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_FACET_ANCHORS_H_
