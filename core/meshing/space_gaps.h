// Which gap an edge of the star has, in space: all around it is its Voronoi face; or a tetrahedron
// at it is too large for a sizing feature.
#ifndef DYNMESH_CORE_MESHING_SPACE_GAPS_H_
#define DYNMESH_CORE_MESHING_SPACE_GAPS_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/geometry/circumball.h"
#include "core/meshing/refinement.h"

namespace dynmesh::meshing {

// Of the star of a Refinement `R`, for as long as that is not changed.
template <class R>
class SpaceGaps {
 public:
  using Candidate = typename R::Candidate;

  explicit SpaceGaps(const R& refinement) : r_(refinement) {
    for (const SpaceStar::Corner& corner : r_.star_.corners()) {
      most_radius2_ = std::max(most_radius2_, corner.r2);
    }
  }

  // Quickly: may an edge of that squared length have a gap?
  bool MayHave(double e2) const { return !r_.sizing_.empty() || IsFarFromCorner(e2); }

  // Has the edge to the neighbour in slot i a gap that a point may be put into?
  bool OfNeighbour(int i, Candidate* gap) const {
    const auto& u = r_.star_[i];
    if (r_.IsSkipped(u.p, false)) return false;
    std::optional<geometry::Point3> x;
    if (IsFarFromCorner(u.d2)) x = r_.rules_.PointInGap(r_.star_, i);
    if (!x && !r_.sizing_.empty()) x = CentreOfTooLarge(i);
    if (!x) return false;
    gap->e2 = u.d2;
    gap->neighbour = u.p;
    gap->left = false;
    gap->x = *x;
    return true;
  }

 private:
  bool IsFarFromCorner(double e2) const { return r_.rules_.IsTooFar(most_radius2_, e2); }

  // A tetrahedron stays as large as it is: the last of its corners to come deals with it, at one of
  // its own edges, of which none is shorter than the ball is large over kCap rho once nothing else
  // is to be done: so here, too, newborns only need be queued, and any view knows the ball. The
  // largest of those at the edge to the neighbour in slot i; none whose centre is outside.
  std::optional<geometry::Point3> CentreOfTooLarge(int i) const {
    const SpaceStar& star = r_.star_;
    std::optional<geometry::Point3> best;
    double most = 0;
    for (int c = 0; c < star.corner_count(); ++c) {
      const auto& corner = star.corner(c);
      if (std::ranges::find(corner.n, i) == corner.n.end() || corner.r2 < most) continue;
      if (!r_.rules_.IsWithinCap(corner.r2, star[i].d2)) continue;
      const auto ids = star.IdsOf(c);
      const bool owned =
          std::ranges::all_of(ids, [&](auto id) { return !SpaceStar::IsGhost(id) && r_.Owns(id); });
      if (!owned || !r_.IsTooLargeCorner(c)) continue;
      const geometry::Point3 x = r_.CentreOf(c);
      if (!r_.InDomain(x) || (best && corner.r2 == most && *best < x)) continue;
      best = x;
      most = corner.r2;
    }
    return best;
  }

  const R& r_;
  double most_radius2_ = 0;
};

// The same of a tetrahedron of the triangulation, rather yes than no: whoever looks at a whole star
// decides. Cheap to make.
template <class R>
class TetrahedronGaps {
 public:
  using SimplexIndex = typename R::Triangulation::SimplexIndex;

  explicit TetrahedronGaps(const R& refinement) : r_(refinement) {}

  // The circumradius of tetrahedron t, squared, at most; infinite if the ball may be too large for
  // a sizing feature.
  double MostRadius2(SimplexIndex t) const {
    const auto& triangulation = *r_.triangulation_;
    // What a star computes of the same corner is larger by less than 4e-9 (space_star.cc).
    if (r_.sizing_.empty() && triangulation.HasSphere(t)) {
      return triangulation.SphereOf(t).high * (1 + 1e-8);
    }
    const auto& corners = triangulation.vertices(t);
    std::array<geometry::Vector3, 3> d;
    std::array<double, 3> d2;
    const geometry::Point3& p = r_.vertices_[corners[3]].p;
    for (int i = 0; i < 3; ++i) {
      d[i] = geometry::Difference(r_.vertices_[corners[i]].p.c, p.c);
      d2[i] = geometry::Dot(d[i], d[i]);
    }
    // (0 1 2 3) is positive, so seen from 3 the others turn the other way.
    const geometry::Circumball ball(d[0], d2[0], d[1], d2[1], d[2], d2[2], true);
    const double r = std::sqrt(ball.r2) * (1 + 1e-9) + 2 * ball.error;
    if (!r_.sizing_.empty() && r < INFINITY) {
      geometry::Point3 centre = p;
      for (int k = 0; k < 3; ++k) centre[k] += ball.w[k];
      if (r_.sizing_.IsTooLarge(centre, r + 2 * ball.error + r_.rules_.ulp())) return INFINITY;
    }
    return r * r;
  }

  // The bucket of edge pq of a tetrahedron of that circumradius if it may have a gap, else
  // kBuckets.
  int BucketOf(VertexIndex p, VertexIndex q, double most_radius2) const {
    const double e2 = geometry::SquaredDistance(r_.vertices_[p].p, r_.vertices_[q].p);
    const bool may_have =
        e2 >= r_.rules_.least_squared_length() && r_.rules_.IsTooFar(most_radius2, e2);
    return may_have ? meshing::BucketOf(e2) : kBuckets;
  }

 private:
  const R& r_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SPACE_GAPS_H_
