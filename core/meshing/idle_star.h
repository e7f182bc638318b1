// Stars without a gap, read off the triangulation at a glance. Most stars of a load have no gap,
// and the triangulation keeps the circle or sphere of each simplex. So the reads of such an
// operation can be recorded without making the star (star_search.h), which computes its corners one
// by one.
//
// The record is the same to the bit:
// 1. Of everything that depends on rounding the payload stores only a coarse value (SetRegion).
// 2. An error bound shows in nearly all cases that both ways give the same stored value.
// 3. In the other cases the star is made.
#ifndef DYNMESH_CORE_MESHING_IDLE_STAR_H_
#define DYNMESH_CORE_MESHING_IDLE_STAR_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/meshing/refinement.h"
#include "core/meshing/star_reads.h"

namespace dynmesh::meshing {

// Records the reads of v's Complete if it certainly has no work. Else returns false and records
// nothing. REQUIRES: if there is a triangulation, FindLink(v) was called.
template <int D, template <class> class E>
bool Refinement<D, E>::ReadIdleStar(Context& context, VertexIndex v, double reach) {
  if constexpr (kTraced) {
    const bool by_edge_alone = by_edge() && sizing_.empty() && facets_.empty();
    if (triangulation_ == nullptr || !by_edge_alone || MayHaveGap(v)) return false;
    const Point& p = vertices_[v].p;
    if constexpr (D == 2) {
      star_.BeginRing(v, p, reach);
    } else {
      star_.BeginLink(v, p, reach);
    }
    StarRegion<D> region(p);
    double doubt = 0;
    if (!AddBallsOfLink(&region, &doubt)) return false;
    // Let doubt bound the difference between a corner of the star and the ball of its simplex.
    // 1. Centres and radii differ by less than doubt, margins by less than doubt / 10.
    // 2. The stored values are distances from v: centre + radius, twice the radius, or at most
    //    twice the length of what of the centre points into an orthant. Each changes by at most 2
    //    doubt.
    // 3. A margin counts at most four times in a stored value: 4 doubt / 10.
    // 4. So a stored value changes by less than 2.4 doubt < 8 doubt. 8 ulps more cover the rounding
    //    of coordinates.
    doubt = 8 * doubt + 8 * rules_.ulp();
    if (!context.payload().SetRegion(region, doubt)) return false;
    context.payload().flag = 0;
    if constexpr (D == 2) {
      for (const auto corner : corners_) context.Read(triangulation_->NextVertex(corner));
    } else {
      WriteStar(link_, [&](std::uint32_t word) { context.Read(word); });
    }
    Extent<D> box = region.box();
    for (int k = 0; k < D; ++k) box.lo[k] -= doubt, box.hi[k] += doubt;
    SubscribeBox(context, box);
    return true;
  }
  return false;
}

// Adds the balls of the simplices at v, as the triangulation keeps them. False if the balls of the
// star may differ much, or if a ball is not within reach. *doubt: how much they may differ. R: the
// radius.
// 1. 2D, the star: T = 1 / sin(angle at v) < 1000 is what doubles lose in a corner. Its centre errs
//    by 2e-15 R times T squared (planar_star.cc), that is by about 2e-9 R.
// 2. 2D, the circle: |circle_error| < 1e-8 R^2 (MayHaveGap). Both are far below doubt = 4e-7 R.
// 3. 3D, the star: a centre errs by at most 1e-9 of the least edge at v (space_star.cc), <= 2e-9 R.
// 4. 3D, the sphere: doubt is its own bound (high - low) / R (Sphere), about 4e-7 R as low and high
//    are floats.
template <int D, template <class> class E>
bool Refinement<D, E>::AddBallsOfLink(StarRegion<D>* region, double* doubt) const {
  const double margin = MarginOf(0);
  const double most_radius = 0.9 * star_.reach();
  if constexpr (D == 2) {
    double largest = 0;
    for (const auto corner : corners_) {
      const auto t = corner.simplex;
      const double facing2 = geometry::SquaredDistance(
          triangulation_->position(triangulation_->NextVertex(corner)),
          triangulation_->position(triangulation_->PreviousVertex(corner)));
      const double r2 = triangulation_->squared_circumradius(t), radius = std::sqrt(r2);
      // sin(angle at v) = facing / (2 r) > 1 / 1000. Circles are known (MayHaveGap).
      if (!(facing2 > 4e-6 * r2) || !(radius < most_radius)) return false;
      largest = std::max(largest, radius);
      region->AddBall(triangulation_->circumcenter(t), radius, margin);
    }
    *doubt = 4e-7 * largest;
  } else {
    for (const auto t : link_.simplices) {
      const auto sphere = triangulation_->SphereOf(t);
      const double radius = std::sqrt(sphere.high);
      if (!(radius < most_radius)) return false;
      *doubt = std::max(*doubt, (sphere.high - sphere.low) / radius);  // about 4e-7 R, from the
                                                                       // rounding to floats
      region->AddBall(sphere.center, radius, margin);
    }
  }
  return true;
}

// Conservative: may return true needlessly, never false wrongly. REQUIRES: FindLink(v) was called.
template <int D, template <class> class E>
bool Refinement<D, E>::MayHaveGap(VertexIndex v) const {
  if constexpr (D == 2) {
    const Point& p = triangulation_->position(v);
    // An edge has no gap if its circles have at most this squared radius. Two conditions that may
    // exclude a gap are left out: on which side of the edge the centre lies, and the apex beyond
    // the edge.
    const auto most_near2 = [&](VertexIndex u) {
      return rules_.MostNear2(geometry::SquaredDistance(triangulation_->position(u), p)) *
             (1 - 1e-6);
    };
    VertexIndex u = triangulation_->NextVertex(corners_.front());
    if (u == Triangulation::kInfinite) return true;
    double near2 = most_near2(u);
    for (const auto corner : corners_) {
      const VertexIndex left = triangulation_->PreviousVertex(corner);
      const double r2 = triangulation_->squared_circumradius(corner.simplex);
      if (!(triangulation_->circle_error(corner.simplex) < 1e-8 * r2)) return true;  // or infinite
      const double left_near2 = most_near2(left);
      if (r2 > near2 && IsOlder(u, v)) return true;
      if (r2 > left_near2 && IsOlder(left, v)) return true;
      u = left;
      near2 = left_near2;
    }
    return false;
  } else {
    constexpr std::size_t kMost = mesh::SmallLinkTables::kMost;
    const auto& neighbours = link_.neighbours;
    if (!link_.is_closed || neighbours.size() > kMost) return true;
    std::array<double, kMost> most_near2;  // by neighbour
    for (std::size_t i = 0; i < neighbours.size(); ++i) {
      const double d2 = geometry::SquaredDistance(triangulation_->position(neighbours[i]),
                                                  triangulation_->position(v));
      most_near2[i] = rules_.MostNear2(d2) * (1 - 1e-6);
    }
    for (std::size_t i = 0; i < link_.triangles.size(); ++i) {
      const auto t = link_.simplices[i];
      if (!triangulation_->HasSphere(t)) return true;
      const double r2 = triangulation_->SphereOf(t).high;
      for (const int u : link_.triangles[i]) {
        if (r2 > most_near2[u] && IsOlder(neighbours[u], v)) return true;
      }
    }
    return false;
  }
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_IDLE_STAR_H_
