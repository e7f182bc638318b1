// Most stars of a load have no gap, and the triangulation knows as much: with each simplex it keeps
// its circle or sphere. So what such an operation has read can be told without making the star
// (star_search.h), whose corners would be computed one by one.
//
// To the bit what it would be: what depends on roundings is kept so coarsely that it is nearly
// always certain in spite of them; where it is not, the star is made.
#ifndef DYNMESH_CORE_MESHING_IDLE_STAR_H_
#define DYNMESH_CORE_MESHING_IDLE_STAR_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/meshing/refinement.h"
#include "core/meshing/star_reads.h"

namespace dynmesh::meshing {

// Records what v's Complete reads, if that has certainly nothing to do; else false, and nothing is
// recorded. REQUIRES: with a triangulation, FindLink(v) was called.
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
    // Centre and radius of a corner differ by less than `doubt` from the sphere's, its margin,
    // which counts four times at most, by less than a tenth of that; what is kept are distances
    // from v, twice the length of what of the centre points into an orthant at most.
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

// The balls of the simplices at v, as the triangulation keeps them, and by how much those of the
// star may differ; false if that may be much, or if some are not within reach. Seen from v, a
// corner's centre errs by 2e-15 of the radius times the square of how much doubles lose in it
// (planar_star.cc), in space by 1e-9 of the least edge (space_star.cc).
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
      // The sine of the angle at v is more than 1 / 1000. Circles are known (MayHaveGap).
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
      *doubt = std::max(*doubt, (sphere.high - sphere.low) / radius);  // 4e-7 of it: floats
      region->AddBall(sphere.center, radius, margin);
    }
  }
  return true;
}

// Rather yes than no. REQUIRES: FindLink(v) was called.
template <int D, template <class> class E>
bool Refinement<D, E>::MayHaveGap(VertexIndex v) const {
  if constexpr (D == 2) {
    const Point& p = triangulation_->position(v);
    // The largest squared radius of a circle at an edge without a gap; its side of the circle's
    // centre and what is beyond the edge, which may fill a gap, are not looked at.
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
