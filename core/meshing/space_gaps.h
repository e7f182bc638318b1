// The gaps of an edge in 3D: its Voronoi face reaches too far, or a tetrahedron at it is too large
// for a sizing region.
#ifndef DYNMESH_CORE_MESHING_SPACE_GAPS_H_
#define DYNMESH_CORE_MESHING_SPACE_GAPS_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/base/rounding.h"
#include "core/geometry/circumball.h"
#include "core/meshing/candidate.h"
#include "core/meshing/complex.h"
#include "core/meshing/star.h"

namespace dynmesh::meshing {

// Of the edges of a star. Views it, as long as it does not change.
template <template <class> class E>
class SpaceGaps {
 public:
  SpaceGaps(const Complex<3, E>& complex, const SpaceStar& star, const SkippedGaps<3>& skipped)
      : complex_(complex), star_(star), skipped_(skipped) {
    for (const SpaceStar::Corner& corner : star_.corners()) {
      most_radius2_ = std::max(most_radius2_, corner.r2);
    }
  }

  // A quick test: may an edge of squared length e2 have a gap?
  bool MayHave(double e2) const { return !complex_.sizing.empty() || IsFarFromCorner(e2); }

  // True if the edge to the neighbour in slot i has a gap with room for a point.
  bool OfNeighbour(int i, Candidate<3>* gap) const {
    const auto& u = star_[i];
    if (skipped_.Has(u.p, false) || complex_.IsSeditious(star_.vertex(), u.id)) return false;
    std::optional<geometry::Point3> x;
    if (IsFarFromCorner(u.d2)) x = complex_.rules.PointInGap(star_, i);
    if (!x && !complex_.sizing.empty()) x = CentreOfTooLarge(i);
    if (!x) return false;
    gap->e2 = u.d2;
    gap->neighbour = u.p;
    gap->left = false;
    gap->x = *x;
    return true;
  }

 private:
  bool IsFarFromCorner(double e2) const { return complex_.rules.IsTooFar(most_radius2_, e2); }

  // The centre of the largest ball among the tetrahedra at the edge to the neighbour in slot i that
  // are too large for a sizing region and are owned by the star's vertex, their youngest corner.
  // Skips centres outside the domain.
  // 1. A tetrahedron never changes its size while it exists. So its youngest corner deals with it,
  //    and here, too, only newborns are queued.
  // 2. It does so at one of its own edges, of length e. Once there is no other work,
  //    e >= R / (kCap rho), R the radius of the ball. So every view that judges the edge knows the
  //    ball.
  std::optional<geometry::Point3> CentreOfTooLarge(int i) const {
    std::optional<geometry::Point3> best;
    double most = 0;
    for (int c = 0; c < star_.corner_count(); ++c) {
      const auto& corner = star_.corner(c);
      if (std::ranges::find(corner.n, i) == corner.n.end() || corner.r2 < most) continue;
      if (!complex_.rules.IsWithinCap(corner.r2, star_[i].d2)) continue;
      const auto ids = star_.IdsOf(c);
      const bool owned = std::ranges::all_of(ids, [&](auto id) {
        return !SpaceStar::IsGhost(id) && complex_.IsOlder(id, star_.vertex());
      });
      if (!owned || !complex_.IsTooLarge(CentreOf(star_, c), corner.r2)) continue;
      const geometry::Point3 x = CentreOf(star_, c);
      if (!complex_.InDomain(x) || (best && corner.r2 == most && *best < x)) continue;
      best = x;
      most = corner.r2;
    }
    return best;
  }

  const Complex<3, E>& complex_;
  const SpaceStar& star_;
  const SkippedGaps<3>& skipped_;
  double most_radius2_ = 0;
};

// The same test for a tetrahedron of the triangulation. Conservative: may find a gap needlessly,
// never misses one; the operation that reads the whole star decides. Cheap to make.
template <template <class> class E>
class TetrahedronGaps {
 public:
  using SimplexIndex = delaunay::DelaunayTetrahedralization::SimplexIndex;

  explicit TetrahedronGaps(const Complex<3, E>& complex) : complex_(complex) {}

  // An upper bound of the squared circumradius of tetrahedron t; infinite if the ball may be too
  // large for a sizing region.
  double MostRadius2(SimplexIndex t) const {
    const auto& triangulation = complex_.run.triangulation();
    // A star computes at most a relative 4e-9 more for this corner (space_star.cc).
    if (complex_.sizing.empty() && triangulation.HasSphere(t)) {
      return triangulation.SphereOf(t).high * (1 + 1e-8);
    }
    const auto& corners = triangulation.vertices(t);
    std::array<geometry::Vector3, 3> d;
    std::array<double, 3> d2;
    const geometry::Point3& p = complex_.vertex(corners[3]).p;
    for (int i = 0; i < 3; ++i) {
      d[i] = geometry::Difference(complex_.vertex(corners[i]).p.c, p.c);
      d2[i] = geometry::Dot(d[i], d[i]);
    }
    // (0 1 2 3) is positive, so seen from 3 the others turn the other way.
    const geometry::Circumball ball(d[0], d2[0], d[1], d2[1], d[2], d2[2], true);
    const double r = std::sqrt(ball.r2) * kBarelyWider + 2 * ball.error;
    if (!complex_.sizing.empty() && r < INFINITY) {
      geometry::Point3 centre = p;
      for (int k = 0; k < 3; ++k) centre[k] += ball.w[k];
      if (complex_.sizing.IsTooLarge(centre, r + 2 * ball.error + complex_.rules.ulp()))
        return INFINITY;
    }
    return r * r;
  }

  // The bucket of edge pq of a tetrahedron with that circumradius if the edge may have a gap, else
  // kBuckets.
  int BucketOf(VertexIndex p, VertexIndex q, double most_radius2) const {
    const double e2 = geometry::SquaredDistance(complex_.vertex(p).p, complex_.vertex(q).p);
    const bool may_have =
        e2 >= complex_.rules.least_squared_length() && complex_.rules.IsTooFar(most_radius2, e2);
    return may_have ? meshing::BucketOf(e2) : kBuckets;
  }

 private:
  const Complex<3, E>& complex_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SPACE_GAPS_H_
