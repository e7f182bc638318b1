// Stars without a gap, read off the triangulation at a glance. Most stars of a load have no gap,
// and the triangulation keeps the circle or sphere of each simplex. So the reads of such an
// operation can be recorded without making the star (star_finder.h), which computes its corners one
// by one.
//
// The record is the same to the bit:
// 1. Of everything that depends on rounding the payload stores only a coarse value (SetCover).
// 2. An error bound shows in nearly all cases that both ways give the same stored value.
// 3. In the other cases the star is made.
#ifndef DYNMESH_CORE_MESHING_IDLE_STAR_H_
#define DYNMESH_CORE_MESHING_IDLE_STAR_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/base/rounding.h"
#include "core/meshing/complex.h"
#include "core/meshing/link.h"
#include "core/meshing/read_cover.h"
#include "core/meshing/star_reads.h"
#include "core/meshing/star_view.h"

namespace dynmesh::meshing {

template <int D, template <class> class E>
class IdleStars {
 public:
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;
  using Link = LinkOf<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;

  explicit IdleStars(const Complex<D, E>& complex) : complex_(complex) {}

  // Records the reads of v's Complete if it certainly has no work. Else returns false and records
  // nothing. `link`: of v in the triangulation.
  bool Read(Context& context, VertexIndex v, double reach, const Link& link) const;
  // 3D, untraced. Has v certainly no work, now and later? Cells only shrink, and an edge that comes
  // is its newborn's. So if nothing of v's cell is missing on a facet, and no edge of v that there
  // is has a gap, no later Complete of v makes anything.
  bool IsDone(VertexIndex v, const Link& link) const;

 private:
  bool AddBallsOf(const Link& link, double reach, ReadCover<D>* cover, double* doubt) const;
  bool MayHaveGap(VertexIndex v, const Link& link) const;

  const Complex<D, E>& complex_;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
bool IdleStars<D, E>::Read(Context& context, VertexIndex v, double reach, const Link& link) const {
  if constexpr (kTraced) {
    const bool by_edge_alone =
        complex_.by_edge() && complex_.sizing.empty() && complex_.facets.empty();
    if (!by_edge_alone || MayHaveGap(v, link)) return false;
    const Point& p = complex_.vertex(v).p;
    ReadCover<D> cover(p);
    double doubt = 0;
    if (!AddBallsOf(link, reach, &cover, &doubt)) return false;
    // Let doubt bound the difference between a corner of the star and the ball of its simplex.
    // 1. Centres and radii differ by less than doubt, margins by less than doubt / 10.
    // 2. The stored values are distances from v: centre + radius, twice the radius, or at most
    //    twice the length of what of the centre points into an orthant. Each changes by at most 2
    //    doubt.
    // 3. A margin counts at most four times in a stored value: 4 doubt / 10.
    // 4. So a stored value changes by less than 2.4 doubt < 8 doubt. 8 ulps more cover the rounding
    //    of coordinates.
    doubt = 8 * doubt + 8 * complex_.rules.ulp();
    if (!context.payload().SetCover(cover, doubt)) return false;
    context.payload().flag = 0;
    context.payload().most_judged = INFINITY;
    if constexpr (D == 2) {
      for (const auto corner : link.corners)
        context.Read(complex_.run.triangulation().NextVertex(corner));
    } else {
      WriteStar(link, [&](std::uint32_t word) { context.Read(word); });
    }
    Extent<D> box = cover.box();
    for (int k = 0; k < D; ++k) box.lo[k] -= doubt, box.hi[k] += doubt;
    complex_.Subscribe(context, box);
    return true;
  }
  return false;
}

// The cell lies in a ball about v, which meets no facet but v's own. Spheres are known
// (MayHaveGap). A star computes at most a relative 4e-9 more for a corner (space_star.cc).
template <int D, template <class> class E>
bool IdleStars<D, E>::IsDone(VertexIndex v, const Link& link) const {
  if constexpr (D == 3 && !kTraced) {
    if (!complex_.by_edge() || !complex_.sizing.empty() || MayHaveGap(v, link)) return false;
    double far2 = 0;
    for (const auto t : link.simplices) {
      far2 = std::max(far2, complex_.run.triangulation().SphereOf(t).high);
    }
    const double far = std::sqrt(far2) * kWider + 4 * complex_.rules.ulp();
    return !complex_.facets.AnyNear(
        complex_.vertex(v).p, far, kNothingHidden,
        [&](const Facet& facet) { return !complex_.IsOnFacet(v, facet); });
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
bool IdleStars<D, E>::AddBallsOf(const Link& link, double reach, ReadCover<D>* cover,
                                 double* doubt) const {
  const double margin = MarginOf<D>(complex_.rules, reach, 0);
  const double most_radius = 0.9 * reach;
  if constexpr (D == 2) {
    double largest = 0;
    for (const auto corner : link.corners) {
      const auto t = corner.simplex;
      const double facing2 = geometry::SquaredDistance(
          complex_.run.triangulation().position(complex_.run.triangulation().NextVertex(corner)),
          complex_.run.triangulation().position(
              complex_.run.triangulation().PreviousVertex(corner)));
      const double r2 = complex_.run.triangulation().squared_circumradius(t),
                   radius = std::sqrt(r2);
      // sin(angle at v) = facing / (2 r) > 1 / 1000. Circles are known (MayHaveGap).
      if (!(facing2 > 4e-6 * r2) || !(radius < most_radius)) return false;
      largest = std::max(largest, radius);
      cover->AddBall(complex_.run.triangulation().circumcenter(t), radius, margin);
    }
    *doubt = 4e-7 * largest;
  } else {
    for (const auto t : link.simplices) {
      const auto sphere = complex_.run.triangulation().SphereOf(t);
      const double radius = std::sqrt(sphere.high);
      if (!(radius < most_radius)) return false;
      *doubt = std::max(*doubt, (sphere.high - sphere.low) / radius);  // about 4e-7 R, from the
                                                                       // rounding to floats
      cover->AddBall(sphere.center, radius, margin);
    }
  }
  return true;
}

// Conservative: may return true needlessly, never false wrongly.
template <int D, template <class> class E>
bool IdleStars<D, E>::MayHaveGap(VertexIndex v, const Link& link) const {
  if constexpr (D == 2) {
    const Point& p = complex_.run.triangulation().position(v);
    // An edge has no gap if its circles have at most this squared radius. Two conditions that may
    // exclude a gap are left out: on which side of the edge the centre lies, and the apex beyond
    // the edge.
    const auto most_near2 = [&](VertexIndex u) {
      return complex_.rules.MostNear2(
                 geometry::SquaredDistance(complex_.run.triangulation().position(u), p)) *
             kNarrower;
    };
    VertexIndex u = complex_.run.triangulation().NextVertex(link.corners.front());
    if (u == TriangulationOf<D>::kInfinite) return true;
    double near2 = most_near2(u);
    for (const auto corner : link.corners) {
      const VertexIndex left = complex_.run.triangulation().PreviousVertex(corner);
      const double r2 = complex_.run.triangulation().squared_circumradius(corner.simplex);
      if (!(complex_.run.triangulation().circle_error(corner.simplex) < 1e-8 * r2))
        return true;  // or infinite
      const double left_near2 = most_near2(left);
      if (r2 > near2 && complex_.IsOlder(u, v)) return true;
      if (r2 > left_near2 && complex_.IsOlder(left, v)) return true;
      u = left;
      near2 = left_near2;
    }
    return false;
  } else {
    constexpr std::size_t kMost = delaunay::SmallLinkTables::kMost;
    const auto& neighbours = link.neighbours;
    if (!link.is_closed || neighbours.size() > kMost) return true;
    std::array<double, kMost> most_near2;  // by neighbour
    for (std::size_t i = 0; i < neighbours.size(); ++i) {
      const double d2 =
          geometry::SquaredDistance(complex_.run.triangulation().position(neighbours[i]),
                                    complex_.run.triangulation().position(v));
      most_near2[i] = complex_.rules.MostNear2(d2) * kNarrower;
    }
    for (std::size_t i = 0; i < link.triangles.size(); ++i) {
      const auto t = link.simplices[i];
      if (!complex_.run.triangulation().HasSphere(t)) return true;
      const double r2 = complex_.run.triangulation().SphereOf(t).high;
      for (const int u : link.triangles[i]) {
        if (r2 > most_near2[u] && complex_.IsOlder(neighbours[u], v)) return true;
      }
    }
    return false;
  }
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_IDLE_STAR_H_
