// What refinement reads beside stars (star_search.h): the distance of the nearest vertex, the
// vertices in a subsegment's ball, the subsegments that a point encroaches on.
//
// All reads are as of the operation's time, and all are recorded as a region.
#ifndef DYNMESH_CORE_MESHING_NEIGHBOURHOOD_H_
#define DYNMESH_CORE_MESHING_NEIGHBOURHOOD_H_

#include <algorithm>
#include <cmath>

#include "core/geometry/constructions.h"
#include "core/meshing/refinement.h"

namespace dynmesh::meshing {

// (a - x).(b - x): < 0 inside the ball with diameter ab, 0 on its surface. Exact.
template <int D>
inline int DiametralBallSign(const geometry::Point<D>& a, const geometry::Point<D>& b,
                             const geometry::Point<D>& x) {
  const int sign = geometry::internal::InDiametralBallFilter(a, b, x);
  return sign != geometry::internal::kUnsure ? sign
                                             : geometry::internal::InDiametralBallExact(a, b, x);
}

// --- Balls --------------------------------------------------------------------------

template <int D, template <class> class E>
typename Refinement<D, E>::Near Refinement<D, E>::NearestTo(Context& context, VertexIndex v) {
  if (triangulation_ != nullptr) {
    if (nearest_.empty()) FindAllNearest();
    return nearest_[v];
  }
  Near best;
  double r2 = INFINITY;
  tree_.VisitBall(vertices_[v].p, r2, [&](std::uint32_t id, const Point&, double d2) {
    // Very many vertices may be equally near: any one will do.
    if (id == v || d2 >= best.d2 || !context.Sees(vertices_[id].birth)) return;
    best = {d2, id};
    r2 = d2;
  });
  return best;
}

// Finds all nearest neighbours at once, as the nearest neighbour is a Delaunay neighbour. A pass
// over the triangles is faster than vertex by vertex in random order. Nothing is inserted in that
// epoch.
template <int D, template <class> class E>
void Refinement<D, E>::FindAllNearest() {
  nearest_.assign(vertices_.size(), {});
  triangulation_->ForEachSimplex([&](auto t) {
    const auto& corners = triangulation_->vertices(t);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const VertexIndex p = corners[i], q = corners[j];
        const double d2 =
            geometry::SquaredDistance(triangulation_->position(p), triangulation_->position(q));
        if (d2 < nearest_[p].d2) nearest_[p] = {d2, q};
        if (d2 < nearest_[q].d2) nearest_[q] = {d2, p};
      }
    }
  });
}

// True if subsegment s is encroached as of now. Then witnesses_ are the vertices that encroach: one
// vertex in the open ball, or vertices on its surface that keep s out of the triangulation (see
// segments.h).
template <int D, template <class> class E>
bool Refinement<D, E>::FindEncroaching(Context& context, SubsegmentIndex s) {
  if (D == 2 && is_global()) return FindEncroachingInTriangulation(s);
  const Subsegment& sub = subsegments_[s];
  const Point &a = vertices_[sub.a].p, &b = vertices_[sub.b].p;
  witnesses_.clear();
  on_surface_.clear();
  const double radius = RadiusOf(sub);
  double r2 = radius * radius;
  tree_.VisitBall(geometry::Midpoint(a, b), r2, [&](std::uint32_t id, const Point& q, double) {
    if (id == sub.a || id == sub.b || !context.Sees(vertices_[id].birth)) return;
    const int sign = DiametralBallSign(a, b, q);
    if (sign < 0) {
      witnesses_.assign(1, id);
      r2 = -1;  // one is enough
    } else if (sign == 0) {
      on_surface_.push_back(id);
    }
  });
  return !witnesses_.empty() || FindHiding(sub);
}

// True if vertices on the surface of the subsegment's ball keep it out of the triangulation.
template <int D, template <class> class E>
bool Refinement<D, E>::FindHiding(const Subsegment& sub) {
  if (on_surface_.size() < 2) return false;
  const Point &a = vertices_[sub.a].p, &b = vertices_[sub.b].p;
  if constexpr (D == 2) {
    for (const VertexIndex c : on_surface_) {
      if (geometry::Orientation(a, b, vertices_[c].p) <= 0) continue;
      for (const VertexIndex d : on_surface_) {
        if (geometry::Orientation(a, b, vertices_[d].p) >= 0) continue;
        if (geometry::InCircle(a, b, vertices_[c].p, vertices_[d].p)) {
          witnesses_ = {c, d};
          return true;
        }
      }
    }
    return false;
  } else {
    // Take the star of a among these vertices alone. The ghosts are too far to matter. The
    // subsegment is an edge iff b is a neighbour in it.
    star_.Begin(sub.a, a, 4 * RadiusOf(sub));
    star_.Insert(sub.b, b);
    for (const VertexIndex c : on_surface_) star_.Insert(c, vertices_[c].p);
    if (star_.Has(sub.b)) return false;
    witnesses_ = on_surface_;
    return true;
  }
}

template <int D, template <class> class E>
bool Refinement<D, E>::FindEncroachingInTriangulation(SubsegmentIndex s) const {
  if constexpr (D == 2) {
    const Subsegment& sub = subsegments_[s];
    const Point &a = vertices_[sub.a].p, &b = vertices_[sub.b].p;
    const auto first = triangulation_->Around(sub.a);
    auto corner = first;
    bool is_edge = false;
    auto in_ball = [&](VertexIndex c) {
      return c != Triangulation::kInfinite && geometry::InDiametralBall(a, b, vertices_[c].p);
    };
    do {
      const auto& tri = triangulation_->vertices(corner.simplex);
      const VertexIndex right = tri[corner.index == 2 ? 0 : corner.index + 1];
      const VertexIndex left = tri[corner.index == 0 ? 2 : corner.index - 1];
      if (right == sub.b) is_edge = true;
      if ((right == sub.b && in_ball(left)) || (left == sub.b && in_ball(right))) return true;
      corner = triangulation_->NextAround(corner);
    } while (corner.simplex != first.simplex);
    return !is_edge;
  }
  return false;
}

template <int D, template <class> class E>
bool Refinement<D, E>::IsVisible(const Context& context, const Subsegment& s) const {
  return s.exposed != sac::kNoStamp && context.Sees(s.exposed) &&
         !(s.death != sac::kNoStamp && context.Sees(s.death));
}

// Finds the visible subsegments that have x in their closed diametral balls.
template <int D, template <class> class E>
void Refinement<D, E>::FindEncroached(Context& context, const Point& x) {
  encroached_.clear();
  encroached_strictly_.clear();
  if (box_only_) {
    // The balls of the domain's sides reach half a grid spacing inwards.
    const double margin = 0.501 * rules_.grid_spacing();
    bool inside = true;
    for (int k = 0; k < D; ++k) {
      inside = inside && rules_.lo()[k] + margin < x[k] && x[k] < rules_.hi()[k] - margin;
    }
    if (inside) return;
  }
  tree_.VisitPath(x, [&](sac::Place place, sac::Parts part) {
    for (const auto& [s, parts] : exposures_.at(place)) {
      if ((parts & part) != part) continue;  // there may be thousands in a cell without points
      const Subsegment& sub = subsegments_[s];
      if (!IsVisible(context, sub)) continue;
      const int sign = DiametralBallSign(vertices_[sub.a].p, vertices_[sub.b].p, x);
      if (sign > 0) continue;
      encroached_.push_back(s);
      encroached_strictly_.push_back(sign < 0);
    }
  });
}

// --- Regions ------------------------------------------------------------------------

template <int D, template <class> class E>
void Refinement<D, E>::SubscribeBox(Context& context, const Extent<D>& box) {
  if constexpr (kTraced) {
    tree_.Cover(box, [&](sac::Place place, sac::Parts parts) { context.Subscribe(place, parts); });
  }
}

template <int D, template <class> class E>
void Refinement<D, E>::SubscribePoint(Context& context, const Point& p) {
  SubscribeBox(context, {p.c, p.c});
}

template <int D, template <class> class E>
Extent<D> Refinement<D, E>::BallOf(const Subsegment& s) const {
  const Point &a = vertices_[s.a].p, &b = vertices_[s.b].p;
  Extent<D> box = Extent<D>::Nothing();
  box.AddBall(geometry::Midpoint(a, b), RadiusOf(s));
  return box;
}

// A little more than the radius of the diametral ball: its centre is rounded.
template <int D, template <class> class E>
double Refinement<D, E>::RadiusOf(const Subsegment& s) const {
  return std::sqrt(geometry::SquaredDistance(vertices_[s.a].p, vertices_[s.b].p)) / 2 * (1 + 1e-6) +
         2 * rules_.ulp();
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_NEIGHBOURHOOD_H_
