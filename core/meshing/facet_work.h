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
#include <vector>

#include "core/geometry/constructions.h"
#include "core/geometry/space_predicates.h"
#include "core/meshing/changes.h"
#include "core/meshing/refinement.h"

namespace dynmesh::meshing {

// 0.5 and 0.6 make meshes 3 to 5 % larger.
inline constexpr double kNearFacet = 0.7;

// --- Vertices on a facet ------------------------------------------------------------------

// The ends of the input segment that v, of containing dimension 1, lies on.
template <int D, template <class> class E>
Facet::Edge Refinement<D, E>::SegmentOf(VertexIndex v) const {
  const Subsegment& split = SplitAt(v);
  return std::minmax(split.whole_a, split.whole_b);
}

template <int D, template <class> class E>
bool Refinement<D, E>::IsOnFacet(VertexIndex v, const Facet& facet) const {
  const Vertex& vertex = vertices_[v];
  if (vertex.dimension == 0) return facet.HasCorner(v);
  if (vertex.dimension == 2) return vertex.feature == facet.feature();
  if (vertex.dimension == D) return false;
  const auto [a, b] = SegmentOf(v);
  return facet.HasEdge(a, b);
}

// True if d is on the side to which the facet's normal points, seen from triangle abc, which lies
// on the facet. Exact: d may be nearer to the facet's plane than the triangle's corners are.
template <int D, template <class> class E>
bool Refinement<D, E>::IsOnNormalsSide(const Facet& facet, VertexIndex a, VertexIndex b,
                                       VertexIndex c, VertexIndex d) const {
  if constexpr (D == 3) {
    const Point &p = vertices_[a].p, &q = vertices_[b].p, &r = vertices_[c].p;
    const auto normal =
        geometry::Cross(geometry::Difference(q.c, p.c), geometry::Difference(r.c, p.c));
    const int side = geometry::Orientation(p, q, r, vertices_[d].p);
    return geometry::Dot(normal, facet.plane().normal) > 0 ? side > 0 : side < 0;
  }
  return false;
}

// The facet that contains triangle abc, a side of a tetrahedron with fourth corner d, seen from the
// side to which the facet's normal points; kNil if there is none. Four vertices of a facet may span
// a flat tetrahedron. Counting on one side only, the facet is covered exactly once all the same.
template <int D, template <class> class E>
FacetIndex Refinement<D, E>::FacetOf(VertexIndex a, VertexIndex b, VertexIndex c,
                                     VertexIndex d) const {
  if constexpr (D == 3) {
    if (facets_.empty()) return kNil;
    const auto holds = [&](FacetIndex i) {
      const Facet& facet = facets_[i];
      if (!IsOnFacet(a, facet) || !IsOnFacet(b, facet) || !IsOnFacet(c, facet)) return false;
      if (IsOnFacet(d, facet) || !IsOnNormalsSide(facet, a, b, c, d)) return false;
      Point middle;
      for (int k = 0; k < 3; ++k) {
        middle[k] = (vertices_[a].p[k] + vertices_[b].p[k] + vertices_[c].p[k]) / 3;
      }
      return facet.IsInside(middle);
    };
    for (const VertexIndex v : {a, b, c}) {
      const Vertex& vertex = vertices_[v];
      if (vertex.dimension == D) return kNil;
      if (vertex.dimension != 2) continue;
      const FacetIndex i = facets_.OfFeature(vertex.feature);
      return i != kNil && holds(i) ? i : kNil;
    }
    const VertexIndex corner = vertices_[a].dimension == 0 ? a : SegmentOf(a).first;
    for (const FacetIndex i : facets_.AtCorner(corner)) {
      if (holds(i)) return i;
    }
  }
  return kNil;
}

// --- Work on facets -----------------------------------------------------------------------

// min(d2, squared distance from v to the nearest facet that it is not on). Counts a facet only if
// v's foot is inside: else an edge of it, which is a feature of its own, is nearest.
template <int D, template <class> class E>
double Refinement<D, E>::FacetDistance2(VertexIndex v, double d2) const {
  if constexpr (D == 3) {
    const Point& p = vertices_[v].p;
    facets_.ForEachNear(p, std::sqrt(d2), [&](const Facet& facet) {
      const double h = facet.plane().Height(p);
      if (h * h < d2 && !IsOnFacet(v, facet) && facet.IsInside(facet.plane().Foot(p))) d2 = h * h;
    });
  }
  return d2;
}

// Finds the nearest point of a facet in the cell of the star's vertex, which is not on that facet.
// A point that is not certainly in view waits until views are wider.
template <int D, template <class> class E>
bool Refinement<D, E>::FindFacetPoint(Candidate* best) {
  if constexpr (D == 3) {
    double far2 = 0;
    for (const auto& corner : star_.corners()) {
      far2 = std::max(far2, corner.error < star_.reach() ? corner.r2 : INFINITY);
    }
    const double far = std::min(std::sqrt(far2), star_.reach()) * (1 + 1e-6);
    bool found = false, begun = false;
    // A box behind a neighbour's bisector is outside of the cell.
    const auto is_hidden = [&](const Point& centre, const geometry::Vector3& half) {
      const auto d = geometry::Difference(centre.c, star_.position().c);
      return std::ranges::any_of(star_.neighbours(), [&](const typename Star::Neighbour& u) {
        if (!Star::IsUsed(u)) return false;
        double least = -0.5 * (1 + 1e-6) * u.d2;  // minimum over the box
        for (int k = 0; k < 3; ++k) {
          least += d[k] * u.d[k] - (half[k] + 4 * rules_.ulp()) * std::fabs(u.d[k]);
        }
        return least > 0;
      });
    };
    facets_.ForEachNear(star_.position(), far, is_hidden, [&](const Facet& facet) {
      if (IsOnFacet(star_.vertex(), facet)) return;
      if (!begun) cut_.Begin(star_);
      begun = true;
      const auto cut = cut_.Of(facet);
      if (!cut || cut->distance2 > star_.reach() * star_.reach()) return;
      if (found &&
          (cut->distance2 > best->e2 || (cut->distance2 == best->e2 && best->x < cut->nearest))) {
        return;
      }
      if (IsSkipped(cut->nearest, false) || (cut->touches && !IsJoinedThrough(facet))) return;
      found = true;
      best->x = best->neighbour = cut->nearest;
      best->e2 = cut->distance2;
      best->facet = facet.feature();
    });
    best->required = found;
    return found;
  }
  return false;
}

// True if an edge of the star goes through the facet, with neither end on it.
template <int D, template <class> class E>
bool Refinement<D, E>::IsJoinedThrough(const Facet& facet) const {
  if constexpr (D == 3) {
    for (int i = 0; i < star_.slot_count(); ++i) {
      if (!IsInView(star_[i]) || IsOnFacet(star_[i].id, facet)) continue;
      if (CellCut::GoesThrough(star_, i, facet)) return true;
    }
  }
  return false;
}

// Moves a gap's point to the facet next to it, if there is one. No vertex is nearer to the point
// than its vertices are, at distance r. So no vertex is nearer to the new position than (1 -
// kNearFacet) r.
template <int D, template <class> class E>
void Refinement<D, E>::MoveToFacet(Candidate* gap) const {
  if constexpr (D == 3) {
    const Point from = gap->x;
    const double r = std::sqrt(geometry::SquaredDistance(from, star_.position()));
    double least = kNearFacet * r;
    facets_.ForEachNear(from, least, [&](const Facet& facet) {
      const double h = std::fabs(facet.plane().Height(from));
      if (!(h <= least)) return;
      const Point foot = facet.plane().Foot(from);
      if (!facet.IsInside(foot)) return;
      if (gap->facet != kNil && h == least && gap->x < foot) return;
      least = h;
      gap->x = foot;
      gap->facet = facet.feature();
      const double nearest = (1 - kNearFacet) * r;
      gap->e2 = nearest * nearest;
    });
  }
}

// --- Changes of input -----------------------------------------------------------------

template <int D, template <class> class E>
FacetIndex Refinement<D, E>::AddFacet(std::span<const std::vector<VertexIndex>> rings,
                                      FeatureSlot feature) {
  if constexpr (D == 3) {
    const FacetIndex index =
        facets_.Add(Facet(rings, feature, [this](VertexIndex v) { return vertices_[v].p; }));
    changed_facets_.push_back(facets_[index]);
    new_facets_.push_back(index);
    return index;
  }
  return kNil;
}

template <int D, template <class> class E>
void Refinement<D, E>::RemoveFacet(FacetIndex index) {
  if constexpr (D == 3) {
    changed_facets_.push_back(facets_[index]);
    std::erase(new_facets_, index);
    if (const auto anchors = facet_anchors_.find(index); anchors != facet_anchors_.end()) {
      for (const auto& [place, v] : anchors->second) RemoveAnchor(v);
      facet_anchors_.erase(anchors);
    }
    facets_.Remove(index);
  }
}

// Notifies of facets that came or went. Facets close together have nearly the same readers: an
// operation that read nothing in the box around a group is tested only once. (An operation that
// read a vertex removed since then is stale and is not tested.)
template <int D, template <class> class E>
void Refinement<D, E>::NotifyOfFacets() {
  if constexpr (!kTraced) return changed_facets_.clear();
  const auto size = [](const Extent<3>& box) {
    return std::max({box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2]});
  };
  for (std::size_t begin = 0, end = 0; begin < changed_facets_.size(); begin = end) {
    Extent<3> group = changed_facets_[begin].where().box;
    double largest = size(group);
    for (end = begin + 1; end < changed_facets_.size(); ++end) {
      const Extent<3>& next = changed_facets_[end].where().box;
      Extent<3> all = group;
      all.AddBall({next.lo}, 0);
      all.AddBall({next.hi}, 0);
      largest = std::max(largest, size(next));
      if (size(all) > 2 * largest) break;
      group = all;
    }
    NotifyOfFacets(group, std::span(changed_facets_).subspan(begin, end - begin));
  }
  changed_facets_.clear();
}

template <int D, template <class> class E>
void Refinement<D, E>::NotifyOfFacets(const Extent<3>& box, std::span<const Facet> facets) {
  if constexpr (kTraced && D == 3) {
    NotifyFromBeginning(
        box,
        [&](const Point& centre, double half) {
          return std::ranges::any_of(facets, [&](const Facet& facet) {
            return facet.where().MayMeet(centre, 1.7321 * half);
          });
        },
        [&](sac::OpId op) {
          return BoxMatters(op, box) && std::ranges::any_of(facets, [&](const Facet& facet) {
                   return FacetMatters(op, facet);
                 });
        });
  }
}

// A facet affects a Presplit within this distance from its piece's middle: nearer than what made it
// split, or near enough to make it split. Conservative.
template <int D, template <class> class E>
double Refinement<D, E>::PresplitReach(sac::OpId op) const {
  if constexpr (kTraced) {
    const Subsegment& s = subsegments_[engine_.item(op)];
    const Payload& payload = engine_.payload(op);
    const double radius2 = payload.flag ? static_cast<double>(payload.radius2) : FacetReach2(s);
    return std::sqrt(radius2) * (1 + 1e-6) + rules_.ulp();
  }
  return 0;
}

// May a ball that the operation read meet the box? All that it read lies in those balls: a point of
// the cell is in the ball about some corner, and so is everything nearer to that point than the
// vertex is. Conservative: may return true needlessly, never false wrongly.
//
// A ball of radius r about the corner v + e meets a ball of radius s about v + w only if w.w - 2
// e.w <= 2 r s + s s (as |e| = r). So it is enough to test the corner with the largest e.w.
template <int D, template <class> class E>
bool Refinement<D, E>::BoxMatters(sac::OpId op, const Extent<3>& box) const {
  if constexpr (kTraced && D == 3) {
    if (!Counts(Term::kOverFacet)) return false;
    if (engine_.kind(op) == kPresplit) {
      const Subsegment& s = subsegments_[engine_.item(op)];
      const Point middle = geometry::Midpoint(vertices_[s.a].p, vertices_[s.b].p);
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
        std::sqrt(static_cast<double>(engine_.payload(op).radius2)) * (1 + 1e-6) + rules_.ulp();
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
    const double s = std::sqrt(s2) + 4 * rules_.ulp();
    const double beyond = w2 * (1 - 1e-6) - radius * s - s * s;  // radius: twice the largest r
    if (engine_.kind(op) != kComplete || !(beyond > 0)) return true;
    const double reach = rules_.Reach(BucketOfEpoch(engine_.epoch(op)));
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
bool Refinement<D, E>::FacetMatters(sac::OpId op, const Facet& changed) const {
  if constexpr (kTraced && D == 3) {
    const FacetPlace& facet = changed.where();
    if (engine_.kind(op) == kPresplit) {
      const Subsegment& s = subsegments_[engine_.item(op)];
      return !changed.HasCorner(s.whole_a) && !changed.HasCorner(s.whole_b) &&
             facet.MayMeet(geometry::Midpoint(vertices_[s.a].p, vertices_[s.b].p),
                           PresplitReach(op));
    }
    if (!BoxMatters(op, facet.box)) return false;
    const double radius = std::sqrt(static_cast<double>(engine_.payload(op).radius2));
    if (!facet.MayMeet(CentreOfReads(op), radius * (1 + 1e-6) + rules_.ulp())) {
      return false;
    }
    if (engine_.kind(op) != kComplete) return true;
    const bool none_meets = ForEachCornerIn<D>(engine_.reads(op), [&](const Corner& corner) {
      const auto ball = BallOfCorner(op, corner);
      return ball.has_value() &&
             !facet.MayMeet(ball->centre, std::sqrt(ball->radius2) * (1 + 1e-6) + rules_.ulp());
    });
    return !none_meets;
  }
  return false;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_FACET_WORK_H_
