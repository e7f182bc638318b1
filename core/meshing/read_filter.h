// The filters of notifications: which changes affect which records.
#ifndef DYNMESH_CORE_MESHING_READ_FILTER_H_
#define DYNMESH_CORE_MESHING_READ_FILTER_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "core/base/rounding.h"
#include "core/geometry/circumball.h"
#include "core/geometry/segment_distance.h"
#include "core/meshing/complex.h"
#include "core/meshing/corner_set.h"
#include "core/meshing/corner_towards.h"
#include "core/meshing/cure.h"
#include "core/meshing/cure_candidates.h"
#include "core/meshing/encroachment.h"
#include "core/meshing/filter_terms.h"
#include "core/meshing/presplit.h"
#include "core/meshing/size_changes.h"
#include "core/meshing/star.h"
#include "core/meshing/star_reads.h"
#include "core/meshing/star_view.h"

namespace dynmesh::meshing {

// "May this change affect what that operation read?" Pure: functions of the complex and of the
// operation's record. Conservative: may return true needlessly, never false wrongly.
// Thread-compatible; a call uses scratch.
template <int D, template <class> class E>
class ReadFilter {
 public:
  using Point = geometry::Point<D>;
  using Subsegment = meshing::Subsegment<D>;
  using Payload = meshing::Payload<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;

  ReadFilter(const Complex<D, E>& complex, const EngineOf<D, E>& engine)
      : complex_(complex), engine_(engine), presplit_(complex) {}

  // v appears or vanishes.
  bool VertexMatters(sac::OpId op, VertexIndex v, bool appears) const;
  // A subsegment with this diametral ball changes, and `op` is attentive.
  bool BallMatters(sac::OpId op, const Point& middle, double radius) const {
    // The candidate was in one of the balls read.
    const double far = std::sqrt(engine_.payload(op).radius2) + radius;
    return IsOn(FilterTerm::kOverYieldedCandidate) &&
           geometry::SquaredDistance(CentreOfReads(op), middle) <= far * far;
  }
  // A subsegment from a to b changes, and `op` made a vertex at x, near its ball.
  bool BallOverOutputMatters(sac::OpId op, const Point& a, const Point& b, const Point& x) const {
    const bool is_steiner = engine_.kind(op) == kComplete || engine_.kind(op) == kCure;
    return IsOn(is_steiner ? FilterTerm::kOverSteinerPoint : FilterTerm::kOverMidpoint) &&
           DiametralBallSign(a, b, x) <= 0;
  }
  // A feature comes or goes.
  bool FeatureMatters(sac::OpId op, const InputFeature<D>& feature, bool appears) const;
  // Sizing regions come or go. May `op` have found a ball too large for one of them and for no
  // other one as fine, or find one now? REQUIRES: MayHaveJudged(op, the least of their radii).
  bool SizesMatter(sac::OpId op, const SizeChanges<D>& changes,
                   const typename SizeChanges<D>::Group& group) const;
  // May `op` have judged by target lengths a ball larger than that? Fast.
  bool MayHaveJudged(sac::OpId op, double radius) const {
    if constexpr (kTraced) {
      const sac::Kind kind = engine_.kind(op);
      return kind == kComplete ? engine_.payload(op).MayHaveJudged(radius)
                               : kind == kPresplit || kind == kCure;
    }
    return false;
  }
  // A facet comes or goes.
  bool FacetMatters(sac::OpId op, const Facet& facet) const;
  // Facets in the box come or go. May a ball that the operation read meet the box? All that it read
  // lies in those balls: a point of the cell is in the ball about some corner, and so is everything
  // nearer to that point than the vertex is.
  //
  // A ball of radius r about the corner v + e meets a ball of radius s about v + w only if w.w - 2
  // e.w <= 2 r s + s s (as |e| = r). So it is enough to test the corner with the largest e.w.
  bool BoxMatters(sac::OpId op, const Extent<3>& box) const;

  // The point from which the payload of a Complete or a Cure measures what was read.
  Point CentreOfReads(sac::OpId op) const;

 private:
  using Corner = typename CornerSet<D>::Corner;  // by its neighbours

  // v is at most as far as the bucket of the nearest vertex. There may be very many in that bucket:
  // the one read stands for all. Conservative: the bucket may stay.
  bool NearestMatters(sac::OpId op, VertexIndex v, bool appears) const;
  // True if v, in the region that `op` read, may change the operation's result. A vertex of
  // refinement in the ball of the sliver itself is not tested: the sliver is gone then, and its
  // operation is dropped. What candidates on facets read is not examined: the answer is true.
  bool CureMatters(sac::OpId op, VertexIndex v, bool appears) const;
  // True if y would be a neighbour in the star that `op` read.
  bool ConflictsWithStar(sac::OpId op, const Point& y) const;
  bool ConflictsWithRing(std::span<const std::uint32_t> ring, const Point& p, double reach,
                         const Point& y) const;
  bool ConflictsWithLink(std::span<const std::uint32_t> words, const Point& p, double reach,
                         const Point& y) const;
  std::optional<Corner> CornerTowards(std::span<const std::uint32_t> words, const Point& p,
                                      double reach, const std::array<double, D>& direction) const;
  std::optional<typename SpatialTree<D>::Ball> BallOfCorner(sac::OpId op, const Corner& ids) const;
  double PresplitReach(sac::OpId op) const;
  // By how much a vertex of a ball that was judged may be off its boundary, as computed.
  static double DoubtOf(const Payload& payload) { return (kWider - 1) * payload.MostReach(); }
  // The two criteria of a Complete. Its vertex lies in each ball that it judged.
  //
  // By edges it judged the balls of corners of which its vertex is the youngest, and of no others:
  // what it made is younger, and so is a corner at it (planar_gaps.h, space_gaps.h).
  bool SizesMatterByEdge(sac::OpId op, const SizeChanges<D>& changes,
                         const typename SizeChanges<D>::Group& group) const;
  // It judged the balls about the corners of the star that it read. If it made vertices, it also
  // judged the corners of the smaller stars that they left. Those balls lie within the union of the
  // former, and none is larger than the largest of them.
  bool SizeMattersByCell(sac::OpId op, const SizingRegion<D>& region) const;

  const Complex<D, E>& complex_;
  const EngineOf<D, E>& engine_;
  PresplitRules<D, E> presplit_;
  mutable std::vector<char> excluded_;  // scratch
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
bool ReadFilter<D, E>::VertexMatters(sac::OpId op, VertexIndex v, bool appears) const {
  if constexpr (kTraced) {
    const Point& y = complex_.vertex(v).p;
    const Payload& payload = engine_.payload(op);
    const sac::Item item = engine_.item(op);
    const auto is_read = [&] {
      const auto reads = engine_.reads(op);
      return std::find(reads.begin(), reads.end(), v) != reads.end();
    };
    switch (engine_.kind(op)) {
      case kComplete:
        if (item == v || !payload.CoverMayHold(complex_.vertex(item).p, y)) return false;
        return appears ? IsOn(FilterTerm::kAppearsInCorner) && ConflictsWithStar(op, y)
                       : IsOn(FilterTerm::kVanishesFromRing) && is_read();
      case kCure:
        return IsOn(FilterTerm::kNearCure) && payload.CoverMayHold(CentreOfReads(op), y) &&
               CureMatters(op, v, appears);
      case kNearest:
        return item != v &&
               geometry::SquaredDistance(complex_.vertex(item).p, y) <= payload.radius2 &&
               IsOn(appears ? FilterTerm::kAppearsNearer : FilterTerm::kNearestVanishes) &&
               NearestMatters(op, v, appears);
      case kCheck:
      case kRecheck: {
        if (payload.flag) return !appears && IsOn(FilterTerm::kWitnessVanishes) && is_read();
        const Subsegment& s = complex_.subsegment(item);
        return appears && IsOn(FilterTerm::kAppearsInBall) && v != s.a && v != s.b &&
               DiametralBallSign(complex_.vertex(s.a).p, complex_.vertex(s.b).p, y) <= 0;
      }
      default:
        return false;
    }
  }
  return false;
}

template <int D, template <class> class E>
bool ReadFilter<D, E>::NearestMatters(sac::OpId op, VertexIndex v, bool appears) const {
  if constexpr (kTraced) {
    const auto reads = engine_.reads(op);
    if (reads.empty()) return true;
    if (!appears) return reads[0] == v;
    const Point& p = complex_.vertex(engine_.item(op)).p;
    return geometry::SquaredDistance(p, complex_.vertex(v).p) <
           geometry::SquaredDistance(p, complex_.vertex(reads[0]).p);
  }
  return false;
}

template <int D, template <class> class E>
bool ReadFilter<D, E>::ConflictsWithStar(sac::OpId op, const Point& y) const {
  if constexpr (kTraced) {
    const Point& p = complex_.vertex(engine_.item(op)).p;
    const double reach = complex_.rules.Reach(BucketOfEpoch(engine_.epoch(op)));
    const auto words = engine_.reads(op);
    if (y == p || words.empty()) return true;
    if constexpr (D == 2) {
      return ConflictsWithRing(words, p, reach, y);
    } else {
      return ConflictsWithLink(words, p, reach, y);
    }
  }
  return false;
}

template <int D, template <class> class E>
bool ReadFilter<D, E>::ConflictsWithRing(std::span<const std::uint32_t> ring, const Point& p,
                                         double reach, const Point& y) const {
  if constexpr (D == 2) {
    const int count = static_cast<int>(ring.size());
    const auto direction = [&](int i) {
      const Point q = PositionInStar(complex_, ring[i], p, reach);
      return std::pair(q[0] - p[0], q[1] - p[1]);
    };
    const auto conflicts = [&](int i) {
      const Point a = PositionInStar(complex_, ring[i], p, reach),
                  b = PositionInStar(complex_, ring[i + 1 == count ? 0 : i + 1], p, reach);
      return y == a || y == b || geometry::InCircle(p, a, b, y);
    };
    const int sector = Star<D>::SectorOf(count, direction, y[0] - p[0], y[1] - p[1]);
    if (sector >= 0) return conflicts(sector);
    for (int i = 0; i < count; ++i) {
      if (conflicts(i)) return true;
    }
  }
  return false;
}

// The corner in `words` that is farthest in the given direction, if rounding leaves no doubt.
template <int D, template <class> class E>
std::optional<typename ReadFilter<D, E>::Corner> ReadFilter<D, E>::CornerTowards(
    std::span<const std::uint32_t> words, const Point& p, double reach,
    const std::array<double, D>& direction) const {
  if constexpr (D == 3) {
    constexpr std::size_t kFew = 64;
    const auto ids = NeighboursIn<D>(words);
    if (ids.size() > kFew) return std::nullopt;
    std::array<geometry::Vector3, kFew> directions;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      directions[i] = geometry::Difference(PositionInStar(complex_, ids[i], p, reach).c, p.c);
    }
    const auto triangles = words.subspan(ids.size());
    const int i = meshing::CornerTowards(
        std::span(directions).first(ids.size()), static_cast<int>(triangles.size()),
        [&](int k) { return IndicesIn(triangles[k]); }, direction);
    if (i < 0) return std::nullopt;
    const auto [a, b, c] = IndicesIn(triangles[i]);
    return Corner{ids[a], ids[b], ids[c]};
  }
  return std::nullopt;
}

// `words`: as read, neighbours and then triangles.
template <int D, template <class> class E>
bool ReadFilter<D, E>::ConflictsWithLink(std::span<const std::uint32_t> words, const Point& p,
                                         double reach, const Point& y) const {
  if constexpr (D == 3) {
    const auto conflicts = [&](const Corner& ids) {
      const Point a = PositionInStar(complex_, ids[0], p, reach),
                  b = PositionInStar(complex_, ids[1], p, reach),
                  c = PositionInStar(complex_, ids[2], p, reach);
      return y == a || y == b || y == c || geometry::InSphere(p, a, b, c, y);
    };
    const auto towards = CornerTowards(words, p, reach, geometry::Difference(y.c, p.c));
    if (towards.has_value()) return conflicts(*towards);
    return !ForEachCornerIn<D>(words, [&](const Corner& corner) { return !conflicts(corner); });
  }
  return false;
}

// The ball about a corner that `op` read; nothing if its error may be large.
template <int D, template <class> class E>
std::optional<typename SpatialTree<D>::Ball> ReadFilter<D, E>::BallOfCorner(
    sac::OpId op, const Corner& ids) const {
  if constexpr (kTraced) {
    const Point& p = complex_.vertex(engine_.item(op)).p;
    const double reach = complex_.rules.Reach(BucketOfEpoch(engine_.epoch(op)));
    std::array<Point, D> positions;
    double shortest = INFINITY;
    for (int k = 0; k < D; ++k) {
      positions[k] = PositionInStar(complex_, ids[k], p, reach);
      shortest = std::min(shortest, geometry::SquaredDistance(positions[k], p));
    }
    const Point x = geometry::Circumcenter(positions, p);
    const double r2 = geometry::SquaredDistance(x, p);
    if (r2 < 1e6 * shortest) return typename SpatialTree<D>::Ball{x, r2};
  }
  return std::nullopt;
}

template <int D, template <class> class E>
bool ReadFilter<D, E>::CureMatters(sac::OpId op, VertexIndex v, bool appears) const {
  if constexpr (kTraced && D == 3) {
    const Sliver& sliver = complex_.slivers[engine_.item(op)];
    if (!sliver.is_there) return false;  // the operation will be dropped
    const auto words = engine_.reads(op);
    const Point& y = complex_.vertex(v).p;
    if (!words.empty() && words[0] == kUnmade) return !appears && words[1] == v;
    if (appears && IsOfCure(complex_.vertex(v)) &&
        complex_.slivers.base().Conflicts(sliver.simplex, y))
      return true;
    for (std::size_t i = 0; i < words.size(); i += 4) {
      const VertexIndex a = words[i + 1], b = words[i + 2], c = words[i + 3];
      if (words[i] == kOnFacet || a == v || b == v || c == v) return true;
      if (appears && geometry::InSphere(CandidateAt(sliver, words[i]), complex_.vertex(a).p,
                                        complex_.vertex(b).p, complex_.vertex(c).p, y)) {
        return true;
      }
    }
    return false;
  }
  return true;
}

template <int D, template <class> class E>
geometry::Point<D> ReadFilter<D, E>::CentreOfReads(sac::OpId op) const {
  if constexpr (kTraced) {
    const sac::Item item = engine_.item(op);
    if constexpr (D == 3) {
      if (engine_.kind(op) == kCure) return complex_.slivers[item].centre;
    }
    return complex_.vertex(item).p;
  }
  return {};
}

template <int D, template <class> class E>
bool ReadFilter<D, E>::FeatureMatters(sac::OpId op, const InputFeature<D>& feature,
                                      bool appears) const {
  if constexpr (kTraced) {
    if (engine_.kind(op) != kPresplit) return false;
    const Subsegment& s = complex_.subsegment(engine_.item(op));
    if (!feature.IsDisjoint(s.whole_a, s.whole_b)) return false;
    const Payload& payload = engine_.payload(op);
    if (!appears) {
      const auto reads = engine_.reads(op);
      return payload.flag && IsOn(FilterTerm::kTooNearVanishes) && !reads.empty() &&
             reads[0] == feature.a && reads[1] == feature.b;
    }
    if (!IsOn(payload.flag ? FilterTerm::kFeatureNearer : FilterTerm::kFeatureTooNear))
      return false;
    const Point middle = geometry::Midpoint(complex_.vertex(s.a).p, complex_.vertex(s.b).p);
    const double d2 = geometry::SquaredDistance(middle, feature.p, feature.q);
    return (!payload.flag || d2 <= payload.radius2) && presplit_.IsTooNear(s, feature, d2);
  }
  return false;
}

template <int D, template <class> class E>
bool ReadFilter<D, E>::SizesMatter(sac::OpId op, const SizeChanges<D>& changes,
                                   const typename SizeChanges<D>::Group& group) const {
  if constexpr (kTraced) {
    if (!IsOn(FilterTerm::kOverSize)) return false;
    const Payload& payload = engine_.payload(op);
    switch (engine_.kind(op)) {
      case kPresplit: {
        const Subsegment& s = complex_.subsegment(engine_.item(op));
        const Point &a = complex_.vertex(s.a).p, &b = complex_.vertex(s.b).p;
        const double half = 0.5 * std::sqrt(geometry::SquaredDistance(a, b));
        return !payload.flag && std::ranges::any_of(group, [&](const auto* change) {
          return presplit_.IsTooLong(s, change->region) &&
                 !changes.AnyOther(*change, geometry::Midpoint(a, b), half, [&](const auto& other) {
                   return presplit_.IsTooLong(s, other);
                 });
        });
      }
      case kCure: {
        const Point centre = CentreOfReads(op);
        const double radius = std::sqrt(double{payload.radius2});
        return std::ranges::any_of(group, [&](const auto* change) {
          return change->region.Meets(centre, radius) &&
                 !changes.IsHidden(*change, centre, radius * kWider);
        });
      }
      case kComplete: {
        const Point& p = complex_.vertex(engine_.item(op)).p;
        const auto may_matter = [&](const auto* change) {
          return payload.MayHaveJudged(change->region.most_radius()) &&
                 change->region.Meets(p, payload.MostReach()) &&
                 !changes.IsHidden(*change, p, DoubtOf(payload));
        };
        if (complex_.by_edge()) {
          return std::ranges::any_of(group, may_matter) && SizesMatterByEdge(op, changes, group);
        }
        return std::ranges::any_of(group, [&](const auto* change) {
          return may_matter(change) && SizeMattersByCell(op, change->region);
        });
      }
      default:
        return false;
    }
  }
  return false;
}

template <int D, template <class> class E>
bool ReadFilter<D, E>::SizesMatterByEdge(sac::OpId op, const SizeChanges<D>& changes,
                                         const typename SizeChanges<D>::Group& group) const {
  if constexpr (kTraced) {
    const VertexIndex v = engine_.item(op);
    const auto words = engine_.reads(op);
    const auto ids = NeighboursIn<D>(words);
    // Neighbours with which no corner matters. A ball has its corner's vertices on its boundary; so
    // if one of them is where the change is hidden, the ball meets what hides it.
    excluded_.clear();
    const double doubt = DoubtOf(engine_.payload(op));
    for (const std::uint32_t id : ids) {
      excluded_.push_back(Star<D>::IsGhost(id) || !complex_.IsOlder(id, v) ||
                          std::ranges::all_of(group, [&](const auto* change) {
                            return changes.IsHidden(*change, complex_.vertex(id).p, doubt);
                          }));
    }
    const auto matters = [&](const std::array<int, D>& corner) {
      Corner of_ids;
      for (std::size_t k = 0; k < D; ++k) {
        const auto i = static_cast<std::size_t>(corner[k]);
        if (excluded_[i]) return false;
        of_ids[k] = ids[i];
      }
      const auto ball = BallOfCorner(op, of_ids);
      if (!ball.has_value()) return true;
      const double r = std::sqrt(ball->radius2), wide = r * kWider + complex_.rules.ulp();
      return std::ranges::any_of(group, [&](const auto* change) {
        return change->region.most_radius() < wide && change->region.Meets(ball->centre, wide) &&
               !changes.IsHiddenFrom(*change, ball->centre, r * kNarrower - complex_.rules.ulp());
      });
    };
    if constexpr (D == 2) {
      const int count = static_cast<int>(ids.size());
      for (int i = 0; i < count; ++i) {
        if (matters({i, i + 1 == count ? 0 : i + 1})) return true;
      }
      return count == 0;
    } else {
      const auto triangles = words.subspan(ids.size());  // none if they were not kept
      return triangles.empty() || std::ranges::any_of(triangles, [&](std::uint32_t triangle) {
               return matters(IndicesIn(triangle));
             });
    }
  }
  return false;
}

template <int D, template <class> class E>
bool ReadFilter<D, E>::SizeMattersByCell(sac::OpId op, const SizingRegion<D>& region) const {
  if constexpr (kTraced) {
    const auto outputs = engine_.outputs(op);
    const bool made = std::any_of(outputs.begin(), outputs.end(),
                                  [](sac::Output o) { return WhatOf(o) == Made::kVertex; });
    const double most = region.most_radius(),
                 view = std::sqrt(static_cast<double>(engine_.payload(op).radius2));
    const Point& p = complex_.vertex(engine_.item(op)).p;
    bool meets = false, too_large = false, both = false, unsure = false;
    const bool kept = ForEachCornerIn<D>(engine_.reads(op), [&](const Corner& ids) {
      const bool at_end = std::ranges::any_of(ids, Star<D>::IsGhost);
      const auto ball = BallOfCorner(op, ids);
      if (!ball.has_value() && !at_end) {
        unsure = true;
        return false;
      }
      const double r =
          ball.has_value() ? std::sqrt(ball->radius2) * kWider + complex_.rules.ulp() : view;
      const bool is_met = region.Meets(ball.has_value() ? ball->centre : p, r), is_large = most < r;
      meets = meets || is_met;
      too_large = too_large || is_large;
      both = both || (is_met && is_large);
      return true;
    });
    if (unsure || !kept) return true;
    return made ? meets && too_large : both;
  }
  return false;
}

// A facet affects a Presplit within this distance from its subsegment's middle: nearer than what
// made it split, or near enough to make it split. Conservative.
template <int D, template <class> class E>
double ReadFilter<D, E>::PresplitReach(sac::OpId op) const {
  if constexpr (kTraced) {
    const Subsegment& s = complex_.subsegment(engine_.item(op));
    const Payload& payload = engine_.payload(op);
    const double radius2 =
        payload.flag ? static_cast<double>(payload.radius2) : presplit_.FacetReach2(s);
    return std::sqrt(radius2) * kWider + complex_.rules.ulp();
  }
  return 0;
}

template <int D, template <class> class E>
bool ReadFilter<D, E>::BoxMatters(sac::OpId op, const Extent<3>& box) const {
  if constexpr (kTraced && D == 3) {
    if (!IsOn(FilterTerm::kOverFacet)) return false;
    if (engine_.kind(op) == kPresplit) {
      const Subsegment& s = complex_.subsegment(engine_.item(op));
      const Point middle = geometry::Midpoint(complex_.vertex(s.a).p, complex_.vertex(s.b).p);
      const double reach = PresplitReach(op);
      double away2 = 0;
      for (int k = 0; k < 3; ++k) {
        const double away = std::max({box.lo[k] - middle[k], middle[k] - box.hi[k], 0.0});
        away2 += away * away;
      }
      return away2 <= reach * reach;
    }
    if (engine_.kind(op) > kComplete && engine_.kind(op) != kCure) return false;
    const Point p = CentreOfReads(op);
    const double radius =
        std::sqrt(static_cast<double>(engine_.payload(op).radius2)) * kWider + complex_.rules.ulp();
    double away2 = 0, w2 = 0, s2 = 0;
    geometry::Vector3 w;
    for (int k = 0; k < 3; ++k) {
      const double away = std::max({box.lo[k] - p[k], p[k] - box.hi[k], 0.0});
      const double half = (box.hi[k] - box.lo[k]) / 2;
      w[k] = (box.lo[k] + box.hi[k]) / 2 - p[k];
      away2 += away * away;
      w2 += w[k] * w[k];
      s2 += half * half;
    }
    if (!(away2 <= radius * radius)) return false;
    if (engine_.kind(op) == kCure) return true;
    const double s = std::sqrt(s2) + 4 * complex_.rules.ulp();
    const double beyond = w2 * kNarrower - radius * s - s * s;  // radius: twice the largest r
    if (engine_.kind(op) != kComplete || !(beyond > 0)) return true;
    const double reach = complex_.rules.Reach(BucketOfEpoch(engine_.epoch(op)));
    const std::optional<Corner> corner = CornerTowards(engine_.reads(op), p, reach, w);
    if (!corner.has_value()) return true;
    const auto ball = BallOfCorner(op, *corner);
    if (!ball.has_value()) return true;
    const auto e = geometry::Difference(ball->centre.c, p.c);
    const double along = geometry::Dot(e, w);
    return !(2 * along + 1e-6 * std::sqrt(ball->radius2 * w2) < beyond);
  }
  return true;
}

template <int D, template <class> class E>
bool ReadFilter<D, E>::FacetMatters(sac::OpId op, const Facet& changed) const {
  if constexpr (kTraced && D == 3) {
    const FacetExtent& facet = changed.where();
    if (engine_.kind(op) == kPresplit) {
      const Subsegment& s = complex_.subsegment(engine_.item(op));
      return !changed.HasCorner(s.whole_a) && !changed.HasCorner(s.whole_b) &&
             facet.MayMeet(geometry::Midpoint(complex_.vertex(s.a).p, complex_.vertex(s.b).p),
                           PresplitReach(op));
    }
    if (!BoxMatters(op, facet.box)) return false;
    const double radius = std::sqrt(static_cast<double>(engine_.payload(op).radius2));
    if (!facet.MayMeet(CentreOfReads(op), radius * kWider + complex_.rules.ulp())) {
      return false;
    }
    if (engine_.kind(op) != kComplete) return true;
    const bool none_meets = ForEachCornerIn<D>(engine_.reads(op), [&](const Corner& corner) {
      const auto ball = BallOfCorner(op, corner);
      return ball.has_value() &&
             !facet.MayMeet(ball->centre, std::sqrt(ball->radius2) * kWider + complex_.rules.ulp());
    });
    return !none_meets;
  }
  return false;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_READ_FILTER_H_
