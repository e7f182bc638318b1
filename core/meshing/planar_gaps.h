// The gaps of an edge in 2D: on either side of it a triangle may be skinny, or too large for a
// sizing region.
//
//   v, u    the edge's ends       c, d    apexes of the triangles left and right of it
#ifndef DYNMESH_CORE_MESHING_PLANAR_GAPS_H_
#define DYNMESH_CORE_MESHING_PLANAR_GAPS_H_

#include <algorithm>
#include <cmath>

#include "core/geometry/constructions.h"
#include "core/meshing/refinement.h"

namespace dynmesh::meshing {

// Reads a Refinement `R`. Cheap to make.
template <class R>
class PlanarGaps {
 public:
  using Point2 = geometry::Point2;
  using Candidate = typename R::Candidate;

  explicit PlanarGaps(const R& refinement) : r_(refinement) {}

  // A quick test: may an edge of squared length e2 have a gap?
  static bool MayHave(double /*e2*/) { return true; }

  // True if the i-th edge of the star has a gap with room for a point. The left side is tested
  // first, seen from the edge's lesser end.
  bool OfNeighbour(int i, Candidate* gap) const {
    const bool left_first = r_.star_.position() < r_.star_[i].p;
    return OnSide(i, left_first, gap) || OnSide(i, !left_first, gap);
  }

  // The bucket of edge pq if it has a gap on the side of c, else kBuckets. (p, q, c) is
  // counter-clockwise; d is the apex on the other side, if there is one. For vertices of the
  // triangulation.
  int BucketOf(VertexIndex p, VertexIndex q, VertexIndex c, VertexIndex d) const {
    constexpr VertexIndex kInfinite = R::Triangulation::kInfinite;
    if (c == kInfinite) return kBuckets;  // beyond the border
    const auto at = [&](VertexIndex v) { return &r_.triangulation_->position(v); };
    const double e2 = geometry::SquaredDistance(*at(p), *at(q));
    const Gap gap = Of(p, *at(p), q, *at(q), e2, c, at(c), d == kInfinite ? nullptr : at(d));
    return gap == Gap::kNone ? kBuckets : meshing::BucketOf(e2);
  }

 private:
  bool OnSide(int i, bool left_of_star, Candidate* gap) const {
    const PlanarStar& star = r_.star_;
    const auto& u = star[i];
    const auto& c = star[left_of_star ? star.Next(i) : star.Prev(i)];
    const auto& d = star[left_of_star ? star.Prev(i) : star.Next(i)];
    // (p, q, c) is counter-clockwise.
    const Point2& p = left_of_star ? star.position() : u.p;
    const Point2& q = left_of_star ? u.p : star.position();
    const bool no_c = PlanarStar::IsGhost(c.id), no_d = PlanarStar::IsGhost(d.id);
    if (no_c && IsOutside(p, q)) return false;
    const Gap what =
        Of(star.vertex(), p, u.id, q, u.d2, c.id, no_c ? nullptr : &c.p, no_d ? nullptr : &d.p);
    if (what == Gap::kNone) return false;
    gap->e2 = u.d2;
    gap->neighbour = u.p;
    gap->left = p < q;
    gap->corner = left_of_star ? i : star.Prev(i);
    if (r_.IsSkipped(gap->neighbour, gap->left)) return false;
    gap->x =
        what == Gap::kOffCenter ? r_.rules_.OffCenter(p, q) : geometry::Circumcenter(p, q, c.p);
    return true;
  }

  // The gap of edge vu according to the rules, or because its triangle with w is too large for a
  // sizing region. p, q, c: the positions of the ends and of w, as for the rules.
  [[gnu::always_inline]] inline Gap Of(VertexIndex v, const Point2& p, VertexIndex u,
                                       const Point2& q, double e2, VertexIndex w, const Point2* c,
                                       const Point2* d) const {
    const Gap gap = r_.rules_.GapOfEdge(p, q, e2, c, d);
    if (gap != Gap::kNone) return r_.IsSeditious(v, u) ? Gap::kNone : gap;
    return !r_.sizing_.empty() && c != nullptr ? OfSize(v, p, u, q, e2, w, *c) : Gap::kNone;
  }

  // A triangle never changes its size while it exists. Its youngest corner deals with it, at one of
  // its own two edges that have the circumcenter on the third corner's side. So here, too, only
  // newborns are queued.
  Gap OfSize(VertexIndex v, const Point2& p, VertexIndex u, const Point2& q, double e2,
             VertexIndex w, const Point2& c) const {
    if (!IsTooLarge(p, q, c, e2)) return Gap::kNone;
    const VertexIndex younger = r_.IsOlder(v, u) ? u : v;
    const bool owned = r_.IsOlder(w, younger);
    return owned && !r_.IsSeditious(v, u) ? Gap::kCircumcenter : Gap::kNone;
  }

  bool IsTooLarge(const Point2& p, const Point2& q, const Point2& c, double e2) const {
    const double px = p[0] - c[0], py = p[1] - c[1], qx = q[0] - c[0], qy = q[1] - c[1];
    const double least2 = r_.rules_.least_squared_length();
    if (e2 < least2 || !(px * qx + py * qy > 0)) return false;
    const Point2 x = geometry::Circumcenter(p, q, c);
    const double r2 = std::max(geometry::SquaredDistance(x, p), geometry::SquaredDistance(x, q));
    return r2 > least2 && r_.sizing_.IsTooLarge(x, std::sqrt(r2));
  }

  // True if the left side of pq is outside of the domain.
  bool IsOutside(const Point2& p, const Point2& q) const {
    const Point2 &lo = r_.rules_.lo(), &hi = r_.rules_.hi();
    return (p[1] == lo[1] && q[1] == lo[1] && q[0] < p[0]) ||
           (p[1] == hi[1] && q[1] == hi[1] && q[0] > p[0]) ||
           (p[0] == lo[0] && q[0] == lo[0] && q[1] > p[1]) ||
           (p[0] == hi[0] && q[0] == hi[0] && q[1] < p[1]);
  }

  const R& r_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_PLANAR_GAPS_H_
