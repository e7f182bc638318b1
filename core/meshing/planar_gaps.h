// The gaps of an edge in 2D: on either side of it a triangle may be skinny, or too large for a
// sizing region.
//
//   v, u    the edge's ends       c, d    apexes of the triangles left and right of it
#ifndef DYNMESH_CORE_MESHING_PLANAR_GAPS_H_
#define DYNMESH_CORE_MESHING_PLANAR_GAPS_H_

#include <algorithm>
#include <cmath>

#include "core/geometry/constructions.h"
#include "core/meshing/candidate.h"
#include "core/meshing/complex.h"
#include "core/meshing/refinement_terms.h"
#include "core/meshing/star.h"

namespace dynmesh::meshing {

// Of the triangles of a triangulation. Cheap to make.
template <template <class> class E>
class TriangleGaps {
 public:
  using Point2 = geometry::Point2;

  explicit TriangleGaps(const Complex<2, E>& complex) : complex_(complex) {}

  // The bucket of edge pq if it has a gap on the side of c, else kBuckets. (p, q, c) is
  // counter-clockwise; d is the apex on the other side, if there is one. For vertices of the
  // triangulation.
  int BucketOf(VertexIndex p, VertexIndex q, VertexIndex c, VertexIndex d) const {
    constexpr VertexIndex kInfinite = delaunay::DelaunayTriangulation::kInfinite;
    if (c == kInfinite) return kBuckets;  // beyond the border
    const auto at = [&](VertexIndex v) { return &complex_.run.triangulation().position(v); };
    const double e2 = geometry::SquaredDistance(*at(p), *at(q));
    const Gap gap = Of(p, *at(p), q, *at(q), e2, c, at(c), d == kInfinite ? nullptr : at(d));
    return gap == Gap::kNone ? kBuckets : meshing::BucketOf(e2);
  }

  // The gap of edge vu according to the rules, or because its triangle with w is too large for a
  // sizing region. p, q, c: the positions of the ends and of w, as for the rules.
  [[gnu::always_inline]] inline Gap Of(VertexIndex v, const Point2& p, VertexIndex u,
                                       const Point2& q, double e2, VertexIndex w, const Point2* c,
                                       const Point2* d) const {
    const Gap gap = complex_.rules.GapOfEdge(p, q, e2, c, d);
    if (gap != Gap::kNone) return complex_.IsSeditious(v, u) ? Gap::kNone : gap;
    return !complex_.sizing.empty() && IsOn(RefinementTerm::kSizesCount) && c != nullptr
               ? OfSize(v, p, u, q, e2, w, *c)
               : Gap::kNone;
  }

 private:
  // A triangle never changes its size while it exists. Its youngest corner deals with it, at one of
  // its own two edges that have the circumcenter on the third corner's side. So here, too, only
  // newborns are queued.
  Gap OfSize(VertexIndex v, const Point2& p, VertexIndex u, const Point2& q, double e2,
             VertexIndex w, const Point2& c) const {
    if (!IsTooLarge(p, q, c, e2)) return Gap::kNone;
    const VertexIndex younger = complex_.IsOlder(v, u) ? u : v;
    const bool owned = complex_.IsOlder(w, younger);
    return owned && !complex_.IsSeditious(v, u) ? Gap::kCircumcenter : Gap::kNone;
  }

  bool IsTooLarge(const Point2& p, const Point2& q, const Point2& c, double e2) const {
    const double px = p[0] - c[0], py = p[1] - c[1], qx = q[0] - c[0], qy = q[1] - c[1];
    const double least2 = complex_.rules.least_squared_length();
    if (e2 < least2 || !(px * qx + py * qy > 0)) return false;
    const Point2 x = geometry::Circumcenter(p, q, c);
    const double r2 = std::max(geometry::SquaredDistance(x, p), geometry::SquaredDistance(x, q));
    return r2 > least2 && complex_.sizing.IsTooLarge(x, std::sqrt(r2));
  }

  const Complex<2, E>& complex_;
};

// Of the edges of a star. Views it, as long as it does not change. Cheap to make.
template <template <class> class E>
class PlanarGaps {
 public:
  using Point2 = geometry::Point2;

  PlanarGaps(const Complex<2, E>& complex, const PlanarStar& star, const SkippedGaps<2>& skipped)
      : complex_(complex), gaps_(complex), star_(star), skipped_(skipped) {}

  // A quick test: may an edge of squared length e2 have a gap?
  static bool MayHave(double /*e2*/) { return true; }

  // True if the i-th edge of the star has a gap with room for a point. The left side is tested
  // first, seen from the edge's lesser end.
  bool OfNeighbour(int i, Candidate<2>* gap) const {
    const bool left_first = (star_.position() < star_[i].p) == IsOn(RefinementTerm::kLeftFirst);
    if (!IsOn(RefinementTerm::kBothSides)) return OnSide(i, left_first, gap);
    return OnSide(i, left_first, gap) || OnSide(i, !left_first, gap);
  }

 private:
  bool OnSide(int i, bool left_of_star, Candidate<2>* gap) const {
    const auto& u = star_[i];
    const auto& c = star_[left_of_star ? star_.Next(i) : star_.Prev(i)];
    const auto& d = star_[left_of_star ? star_.Prev(i) : star_.Next(i)];
    // (p, q, c) is counter-clockwise.
    const Point2& p = left_of_star ? star_.position() : u.p;
    const Point2& q = left_of_star ? u.p : star_.position();
    const bool no_c = PlanarStar::IsGhost(c.id), no_d = PlanarStar::IsGhost(d.id);
    if (no_c && IsOutside(p, q)) return false;
    const Gap what = gaps_.Of(star_.vertex(), p, u.id, q, u.d2, c.id, no_c ? nullptr : &c.p,
                              no_d ? nullptr : &d.p);
    if (what == Gap::kNone) return false;
    gap->e2 = u.d2;
    gap->neighbour = u.p;
    gap->left = p < q;
    gap->corner = left_of_star ? i : star_.Prev(i);
    if (skipped_.Has(gap->neighbour, gap->left)) return false;
    gap->x = what == Gap::kOffCenter ? complex_.rules.OffCenter(p, q)
                                     : geometry::Circumcenter(p, q, c.p);
    return true;
  }

  // True if the left side of pq is outside of the domain.
  bool IsOutside(const Point2& p, const Point2& q) const {
    const Point2 &lo = complex_.rules.lo(), &hi = complex_.rules.hi();
    return (p[1] == lo[1] && q[1] == lo[1] && q[0] < p[0]) ||
           (p[1] == hi[1] && q[1] == hi[1] && q[0] > p[0]) ||
           (p[0] == lo[0] && q[0] == lo[0] && q[1] > p[1]) ||
           (p[0] == hi[0] && q[0] == hi[0] && q[1] < p[1]);
  }

  const Complex<2, E>& complex_;
  const TriangleGaps<E> gaps_;
  const PlanarStar& star_;
  const SkippedGaps<2>& skipped_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_PLANAR_GAPS_H_
