// Facet work (rule b): the Voronoi cell of a vertex that is not on a facet must not meet the facet.
// If it does, the point of the intersection nearest to the vertex becomes a vertex of the facet. If
// that point would encroach on a subsegment, the subsegment is split first and the vertex runs
// again. In the end each facet is a union of triangles of the triangulation, its subfacets
// (cell_cut.h says why).
//
// A gap's Steiner point at distance r from its vertices moves to a facet at distance h <=
// kNearFacet r. Else the facet would soon get a vertex next to it.
#ifndef DYNMESH_CORE_MESHING_FACET_WORK_H_
#define DYNMESH_CORE_MESHING_FACET_WORK_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/base/rounding.h"
#include "core/geometry/constructions.h"
#include "core/meshing/candidate.h"
#include "core/meshing/cell_cut.h"
#include "core/meshing/complex.h"
#include "core/meshing/refinement_terms.h"
#include "core/meshing/sharp_facets.h"
#include "core/meshing/star.h"

namespace dynmesh::meshing {

// 0.5 and 0.6 make meshes 3 to 5 % larger.
inline constexpr double kNearFacet = 0.7;
// Squared. A counterpart may have vertices nearer to it than the one that it is the counterpart of.
// Its first work comes as if the nearest were at half of that distance: too early does no harm.
inline constexpr double kNearCounterpart = 0.25;
// Where facet F meets G at a small dihedral angle along an edge, new points on F near G are moved
// to a lattice in F along that edge (sharp_facets.h), with a step of at most the distance to the
// nearest vertex. All facets at the edge have the same lattice, turned about it. So counterparts
// coincide or are far apart. Otherwise they would come close to each other, points would come
// between them, and these would have counterparts on the other facets, without end. Half of that
// step makes larger meshes.
//
// At a common corner there is no lattice. There a point that comes nearer than this to the
// counterpart of another vertex is moved onto it. In units of the distance from the point to the
// vertex at work; for the point of a gap, of the gap's radius. 0.1 and 0.2 of a gap make larger
// meshes.
inline constexpr double kGivesWay = 0.3, kGapGivesWay = 0.15;

// A place on a facet; there is none if `facet` is null.
struct PlaceOnFacet {
  geometry::Point3 p = {};
  const Facet* facet = nullptr;
};
// The foot of x on the facet nearest to it, if that is no farther than kNearFacet r.
inline PlaceOnFacet FootNear(const FacetField& facets, const geometry::Point3& x, double r) {
  PlaceOnFacet nearest;
  double least = kNearFacet * r;
  facets.ForEachNear(x, least, [&](const Facet& facet) {
    const double h = std::fabs(facet.plane().Height(x));
    if (!(h <= least)) return;
    const geometry::Point3 foot = facet.plane().Foot(x);
    if (!facet.IsInside(foot)) return;
    if (nearest.facet != nullptr && h == least && nearest.p < foot) return;
    least = h;
    nearest = {foot, &facet};
  });
  return nearest;
}

// The counterpart of v on the facet (sharp_facets.h), which v is not on; `nearest`: the place there
// that is nearest to v. Of several the one nearest to v, of these the least. Nothing if there is
// none.
template <template <class> class E>
std::optional<Counterpart> CounterpartOn(const Facet& facet, const Complex<3, E>& complex,
                                         VertexIndex v, const geometry::Point3& nearest) {
  const int dimension = complex.vertex(v).dimension;
  if (dimension == 3) return std::nullopt;
  const geometry::Point3& p = complex.vertex(v).p;
  std::optional<Counterpart> best;
  double least = INFINITY;
  complex.ForEachFacetOf(v, [&](const Facet& own) {
    const auto x = TurnedInto(facet, own, p);
    if (!x) return;
    const double d2 = geometry::SquaredDistance(x->p, p);
    if (d2 > least || (d2 == least && !(x->p < best->p))) return;
    best = x;
    least = d2;
  });
  if (best || dimension == 0) return best;
  return MovedInto(facet, complex.OwnedVertexOf(v), nearest);
}

// In 2D there are no facets: nothing is found. Thread-compatible.
template <int D, template <class> class E>
class FacetWork {
 public:
  using Point = geometry::Point<D>;

  explicit FacetWork(const Complex<D, E>& complex) : complex_(complex) {}

  bool is_needed() const { return D == 3 && !complex_.facets.empty(); }
  // min(d2, squared distance from v to the nearest facet that it is not on). Counts a facet only if
  // v's foot is inside: else an edge of it, which is a feature of its own, is nearest.
  double Distance2(VertexIndex v, double d2) const;
  // Finds the nearest point of a facet in the cell of the star's vertex, which is not on that
  // facet. A point that is not certainly in view waits until views are wider.
  bool FindPoint(const Star<D>& star, const SkippedGaps<D>& skipped, Candidate<D>* best);
  // Moves a gap's point to the facet next to it, if there is one. No vertex is nearer to the point
  // than its vertices are, at distance r. So no vertex is nearer to the new position than (1 -
  // kNearFacet) r; of one that gives way (1 - kNearFacet - kGapGivesWay) r.
  void MoveToFacet(const Star<D>& star, Candidate<D>* gap) const;
  // True if the cell of the star's vertex, which is to lie on facet `on`, meets no other facet.
  bool LeavesWhole(const Star<D>& star, FeatureSlot on);
  // A ball about a point of a facet: if it holds no vertex, LeavesWhole(x's star, on) is false.
  // Nothing if such a facet is not at hand. The ball's surface goes near x.
  struct Room {
    Point centre;
    double radius;
  };
  std::optional<Room> RoomThatIsCut(const Point& x, FeatureSlot on) const;

 private:
  // Moves the point of a facet to the nearest counterpart there of v or a neighbour, of several the
  // least. False if none is within that distance of it.
  bool GiveWay(const Star<D>& star, double within, Candidate<D>* point) const;
  // Moves the point of a facet to the lattice about an edge (sharp_facets.h). False if no other
  // facet has that edge at a small angle and the turned point in the ball, which has no vertex
  // inside. `free`: the distance from the point to the ball's surface.
  bool MoveToLattice(const Point& centre, double radius, double free, Candidate<D>* point) const;
  // The box of the cell's corners; all of space if one of them is not known well. A vertex on a
  // surface has distant corners outside, mostly in one direction, and a ball that holds them has
  // much of the surface. `far`: the distance of the farthest one that matters.
  Extent<D> BoxOfCell(const Star<D>& star, double far) const;
  // True if a neighbour's bisector has the box behind it. Conservative: may return false
  // needlessly.
  bool IsOutsideOfCell(const Star<D>& star, const Point& centre,
                       const std::array<double, D>& half) const;
  // True if a neighbour is at x, within rounding.
  bool HasNeighbourAt(const Star<D>& star, const Point& x) const;
  // True if an edge of the star goes through the facet, with neither end on it.
  bool IsJoinedThrough(const Star<D>& star, const Facet& facet) const;

  const Complex<D, E>& complex_;
  CellCut cut_;
  // Of IsOutsideOfCell: what is behind a neighbour's bisector is mostly behind the last one's.
  mutable std::size_t last_behind_ = 0;
  // Of LeavesWhole: places tried one after the other are mostly near the same facet.
  FeatureSlot last_met_ = kNil;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
double FacetWork<D, E>::Distance2(VertexIndex v, double d2) const {
  if constexpr (D == 3) {
    const Point& p = complex_.vertex(v).p;
    complex_.facets.ForEachNear(p, std::sqrt(d2), [&](const Facet& facet) {
      const double h = facet.plane().Height(p);
      if (h * h < d2 && !complex_.IsOnFacet(v, facet) && facet.IsInside(facet.plane().Foot(p)))
        d2 = h * h;
    });
  }
  return d2;
}

template <int D, template <class> class E>
bool FacetWork<D, E>::FindPoint(const Star<D>& star, const SkippedGaps<D>& skipped,
                                Candidate<D>* best) {
  if constexpr (D == 3) {
    double far2 = 0;
    for (const auto& corner : star.corners()) {
      far2 = std::max(far2, corner.error < star.reach() ? corner.r2 : INFINITY);
    }
    const double far = std::min(std::sqrt(far2), star.reach()) * kWider;
    bool found = false, begun = false;
    std::optional<Counterpart> counterpart;  // of v, on the facet of the best point
    const Extent<D> cell = BoxOfCell(star, far);
    const auto is_hidden = [&](const Point& centre, const geometry::Vector3& half) {
      return !cell.MayMeet(centre, half) || IsOutsideOfCell(star, centre, half);
    };
    complex_.facets.ForEachNear(star.position(), far, is_hidden, [&](const Facet& facet) {
      if (complex_.IsOnFacet(star.vertex(), facet)) return;
      if (!begun) cut_.Begin(star);
      begun = true;
      const auto cut = cut_.Of(facet);
      if (!cut || cut->distance2 > star.reach() * star.reach()) return;
      if (found &&
          (cut->distance2 > best->e2 || (cut->distance2 == best->e2 && best->x < cut->nearest))) {
        return;
      }
      if (skipped.Has(cut->nearest, false) ||
          (cut->touches && IsOn(RefinementTerm::kTouchingIsNoCut) &&
           !IsJoinedThrough(star, facet))) {
        return;
      }
      // All of the facet is nearer to v's counterpart than to v: what is left is rounding.
      const auto other = CounterpartOn(facet, complex_, star.vertex(), cut->nearest);
      if (other && HasNeighbourAt(star, other->p)) return;
      found = true;
      best->x = best->neighbour = cut->nearest;
      best->e2 = cut->distance2;
      best->facet = facet.feature();
      counterpart = other;
    });
    best->required = found;
    if (!found) return false;
    if (counterpart) {
      best->x = counterpart->p;
      best->e2 = kNearCounterpart * geometry::SquaredDistance(best->x, star.position());
      best->origin = {star.vertex(), counterpart->axis};
      return true;
    }
    const double h = std::sqrt(best->e2);
    if (MoveToLattice(star.position(), h, h, best)) return true;
    if (GiveWay(star, kGivesWay * h, best)) best->e2 = (1 - kGivesWay) * (1 - kGivesWay) * best->e2;
    return true;
  }
  return false;
}

template <int D, template <class> class E>
bool FacetWork<D, E>::GiveWay(const Star<D>& star, double within, Candidate<D>* point) const {
  bool found = false;
  if constexpr (D == 3) {
    const Facet& facet = complex_.facets[complex_.facets.OfFeature(point->facet)];
    const Point at = point->x;
    double least = within * within;
    const auto offer = [&](VertexIndex u) {
      if (complex_.vertex(u).dimension != 2 || complex_.IsOnFacet(u, facet)) return;
      const auto other = CounterpartOn(facet, complex_, u, at);
      if (!other) return;
      const double d2 = geometry::SquaredDistance(other->p, at);
      if (d2 > least || (d2 == least && !(found && other->p < point->x))) return;
      found = true;
      least = d2;
      point->x = other->p;
      point->origin = {u, other->axis};
    };
    offer(star.vertex());
    for (int i = 0; i < star.slot_count(); ++i) {
      if (IsInView<D>(star[i])) offer(star[i].id);
    }
  }
  return found;
}

template <int D, template <class> class E>
bool FacetWork<D, E>::MoveToLattice(const Point& centre, double radius, double free,
                                    Candidate<D>* point) const {
  if constexpr (D == 3) {
    const Facet& facet = complex_.facets[complex_.facets.OfFeature(point->facet)];
    const Point x = point->x;
    Axis axis = kNoAxis;
    using Ends = std::pair<Point, Point>;
    Ends first;  // of several axes at one distance the one with the least ends
    double least = INFINITY;
    complex_.facets.ForEachNear(centre, radius, [&](const Facet& other) {
      if (&other == &facet) return;
      const auto turned = TurnedInto(other, facet, x);
      if (!turned || !(geometry::SquaredDistance(turned->p, centre) < radius * radius)) return;
      const Ends ends =
          std::minmax(facet.PositionOf(turned->axis[0]), facet.PositionOf(turned->axis[1]));
      const double d2 = geometry::SquaredDistance(x, ends.first, ends.second);
      if (d2 > least || (d2 == least && !(ends < first))) return;
      least = d2;
      axis = turned->axis;
      first = ends;
    });
    if (axis == kNoAxis) return false;
    const auto place = OnLattice(facet, axis, x, free);
    if (!place) return false;
    point->x = place->p;
    const double nearest = (1 - kFarthestOnLattice) * free;
    point->e2 = nearest * nearest;
    point->origin = {kNil, axis, place->at};
    return true;
  }
  return false;
}

template <int D, template <class> class E>
Extent<D> FacetWork<D, E>::BoxOfCell(const Star<D>& star, double far) const {
  Extent<D> box = Extent<D>::Nothing();
  if constexpr (D == 3) {
    // The cell that CellCut clips by is larger by 2e-11. It begins with a square as wide as the
    // reach, and rounds to that.
    const double margin = 1e-9 * far + 1e-14 * star.reach() + 4 * complex_.rules.ulp();
    for (int i = 0; i < star.corner_count(); ++i) {
      const auto& corner = star.corner(i);
      if (!(corner.error < star.reach())) {
        box.lo.fill(-INFINITY);
        box.hi.fill(INFINITY);
        return box;
      }
      box.AddBall(CentreOf(star, i), corner.error + margin);
    }
  }
  return box;
}

template <int D, template <class> class E>
bool FacetWork<D, E>::IsOutsideOfCell(const Star<D>& star, const Point& centre,
                                      const std::array<double, D>& half) const {
  if constexpr (D == 3) {
    const auto d = geometry::Difference(centre.c, star.position().c);
    bool holds_vertex = true;
    for (std::size_t k = 0; k < 3; ++k) holds_vertex &= std::fabs(d[k]) <= half[k];
    if (holds_vertex) return false;
    const auto has_behind = [&](const typename Star<D>::Neighbour& u) {
      if (!Star<D>::IsUsed(u)) return false;
      double least = -0.5 * kWider * u.d2;  // minimum over the box
      for (int k = 0; k < 3; ++k) {
        least += d[k] * u.d[k] - (half[k] + 4 * complex_.rules.ulp()) * std::fabs(u.d[k]);
      }
      return least > 0;
    };
    const auto& neighbours = star.neighbours();
    if (last_behind_ < neighbours.size() && has_behind(neighbours[last_behind_])) return true;
    const auto found = std::ranges::find_if(neighbours, has_behind);
    if (found == neighbours.end()) return false;
    last_behind_ = static_cast<std::size_t>(found - neighbours.begin());
    return true;
  }
  return false;
}

template <int D, template <class> class E>
bool FacetWork<D, E>::HasNeighbourAt(const Star<D>& star, const Point& x) const {
  constexpr double kRounding2 = 0x1p-60;  // squared, in units of the distance from v
  const double least2 = kRounding2 * geometry::SquaredDistance(star.position(), x);
  for (int i = 0; i < star.slot_count(); ++i) {
    if (IsInView<D>(star[i]) && geometry::SquaredDistance(star[i].p, x) <= least2) return true;
  }
  return false;
}

template <int D, template <class> class E>
bool FacetWork<D, E>::IsJoinedThrough(const Star<D>& star, const Facet& facet) const {
  if constexpr (D == 3) {
    for (int i = 0; i < star.slot_count(); ++i) {
      if (!IsInView<D>(star[i]) || complex_.IsOnFacet(star[i].id, facet)) continue;
      if (CellCut::GoesThrough(star.position(), star[i], facet)) return true;
    }
  }
  return false;
}

template <int D, template <class> class E>
void FacetWork<D, E>::MoveToFacet(const Star<D>& star, Candidate<D>* gap) const {
  if constexpr (D == 3) {
    const double r = std::sqrt(geometry::SquaredDistance(gap->x, star.position()));
    const PlaceOnFacet foot = FootNear(complex_.facets, gap->x, r);
    if (foot.facet == nullptr) return;
    const Point centre = gap->x;
    gap->x = foot.p;
    gap->facet = foot.facet->feature();
    const double to_foot = std::sqrt(geometry::SquaredDistance(centre, foot.p));
    if (MoveToLattice(centre, r, r - to_foot, gap)) return;
    const bool gives_way = GiveWay(star, kGapGivesWay * r, gap);
    const double nearest = (1 - kNearFacet - (gives_way ? kGapGivesWay : 0)) * r;
    gap->e2 = nearest * nearest;
  }
}

template <int D, template <class> class E>
bool FacetWork<D, E>::LeavesWhole(const Star<D>& star, FeatureSlot on) {
  if constexpr (D == 3) {
    if (complex_.facets.empty()) return true;
    double far2 = 0;
    for (const auto& corner : star.corners()) far2 = std::max(far2, corner.r2);
    const double far = std::sqrt(far2) * kWider;
    const Extent<D> cell = BoxOfCell(star, far);
    const auto is_hidden = [&](const Point& centre, const geometry::Vector3& half) {
      return !cell.MayMeet(centre, half) || IsOutsideOfCell(star, centre, half);
    };
    const auto is_met = [&](const Facet& facet) {
      if (facet.feature() == on) return false;
      const auto cut = cut_.Of(facet);
      if (!cut || (cut->touches && IsOn(RefinementTerm::kTouchingIsNoCut) &&
                   !IsJoinedThrough(star, facet))) {
        return false;
      }
      last_met_ = facet.feature();
      return true;
    };
    cut_.Begin(star);
    const FacetIndex last = complex_.facets.OfFeature(last_met_);
    if (last != kNil && is_met(complex_.facets[last])) return false;
    return !complex_.facets.AnyNear(star.position(), far, is_hidden, is_met);
  }
  return true;
}

// The centre is x's foot on the facet that was met last. Without a vertex there it is in x's cell,
// as a tenth of the way to x is left all around it.
template <int D, template <class> class E>
std::optional<typename FacetWork<D, E>::Room> FacetWork<D, E>::RoomThatIsCut(const Point& x,
                                                                             FeatureSlot on) const {
  constexpr double kClear = 1.1;
  constexpr double kOffPlane = 1e4;  // in ulps: the foot is exact enough
  if constexpr (D == 3) {
    if (last_met_ == kNil || last_met_ == on) return std::nullopt;
    const FacetIndex last = complex_.facets.OfFeature(last_met_);
    if (last == kNil) return std::nullopt;
    const Facet& facet = complex_.facets[last];
    const double height = std::fabs(facet.plane().Height(x));
    if (!(height > kOffPlane * complex_.rules.ulp())) return std::nullopt;
    const Point foot = facet.plane().Foot(x);
    if (!facet.IsInside(foot)) return std::nullopt;
    return Room{foot, kClear * height};
  }
  return std::nullopt;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_FACET_WORK_H_
