#include "core/plc/rules.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/rounding.h"
#include "core/geometry/collinear.h"
#include "core/geometry/constructions.h"
#include "core/geometry/predicates.h"
#include "core/geometry/segment_distance.h"
#include "core/geometry/space_predicates.h"
#include "core/geometry/vectors.h"
#include "core/plc/validation_terms.h"
#include "dynmesh/feature.h"

namespace dynmesh::plc {
namespace {

using geometry::AreCollinear;
using geometry::Dot;
using geometry::Minus;
using geometry::Orientation;
using geometry::Point;
using geometry::Point2;
using geometry::Point3;
using geometry::SquaredDistance;

// (|u||w| sin)^2.
template <std::size_t D>
double SquaredCross(const std::array<double, D>& u, const std::array<double, D>& w) {
  double sum = 0;
  for (std::size_t i = 0; i < D; ++i) {
    for (std::size_t j = i + 1; j < D; ++j) {
      const double minor = u[i] * w[j] - u[j] * w[i];
      sum += minor * minor;
    }
  }
  return sum;
}

Point2 Without(int axis, const Point3& p) { return {{p[(axis + 1) % 3], p[(axis + 2) % 3]}}; }

// Of collinear a, b, x: is x on the closed segment ab? Exact.
template <int D>
bool InRange(const Point<D>& a, const Point<D>& b, const Point<D>& x) {
  for (int i = 0; i < D; ++i) {
    if (x[i] < std::min(a[i], b[i]) || x[i] > std::max(a[i], b[i])) return false;
  }
  return true;
}

// Segments apex-a and apex-b.
template <int D>
Conflict AtSharedEnd(const Point<D>& apex, const Point<D>& a, const Point<D>& b) {
  const auto u = Minus(a, apex), w = Minus(b, apex);
  const double d = Dot(u, w);
  // Collinear vectors are opposite or parallel, far from d = 0: the sign of d is right.
  if (d > 0 && IsOn(ValidationTerm::kSegmentsDoNotOverlap) && AreCollinear(apex, a, b)) {
    return Conflict::kSegmentsOverlap;
  }
  if (!IsOn(D == 2 ? ValidationTerm::kAngleOfSegments2D : ValidationTerm::kAngleOfSegments3D)) {
    return Conflict::kNone;
  }
  const double squares = Dot(u, u) * Dot(w, w);
  return d > 0 && SquaredCross(u, w) < kLeastSine2 * squares ? Conflict::kSmallAngle
                                                             : Conflict::kNone;
}

template <int D>
bool CollinearOverlap(const Point<D>& a, const Point<D>& b, const Point<D>& c, const Point<D>& d) {
  if (!IsOn(ValidationTerm::kSegmentsDoNotOverlap)) return false;
  // Lexicographic order is the order along a common line.
  const auto [lo1, hi1] = std::minmax(a, b);
  const auto [lo2, hi2] = std::minmax(c, d);
  return std::max(lo1, lo2) < std::min(hi1, hi2);
}

Conflict Disjoint(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const int c_side = Orientation(a, b, c), d_side = Orientation(a, b, d);
  if (c_side * d_side > 0) return Conflict::kNone;
  if (c_side == 0 && d_side == 0) {
    return CollinearOverlap(a, b, c, d) ? Conflict::kSegmentsOverlap : Conflict::kNone;
  }
  if (c_side == 0 || d_side == 0) return Conflict::kNone;
  if (!IsOn(ValidationTerm::kSegmentsDoNotCross)) return Conflict::kNone;
  return Orientation(c, d, a) * Orientation(c, d, b) < 0 ? Conflict::kSegmentsCross
                                                         : Conflict::kNone;
}

// Segments in one plane meet iff they do in a projection that keeps them apart.
Conflict Disjoint(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  if (Orientation(a, b, c, d) != 0) return Conflict::kNone;
  for (int axis = 0; axis < 3; ++axis) {
    const Point2 a2 = Without(axis, a), b2 = Without(axis, b);
    const Point2 c2 = Without(axis, c), d2 = Without(axis, d);
    const bool on_a_line = AreCollinear(a2, b2, c2) && AreCollinear(a2, b2, d2) &&
                           AreCollinear(c2, d2, a2) && AreCollinear(c2, d2, b2);
    if (!on_a_line) return Disjoint(a2, b2, c2, d2);
  }
  return CollinearOverlap(a, b, c, d) ? Conflict::kSegmentsOverlap : Conflict::kNone;
}

double SquaredDistanceToSegment(const Point3& p, const Point3& lo, const Point3& hi) {
  const auto d = Minus(hi, lo), w = Minus(p, lo);
  const double length2 = Dot(d, d), along = Dot(d, w);
  if (along <= 0) return Dot(w, w);
  if (along >= length2) return SquaredDistance(p, hi);
  return SquaredCross(d, w) / length2;
}

// Do two segments pass each other nearer than `limit`, away from their ends? The ends are points,
// with a rule of their own.
bool PassNear(std::pair<Point3, Point3> s, std::pair<Point3, Point3> t, double limit) {
  if (s.second < s.first) std::swap(s.first, s.second);
  if (t.second < t.first) std::swap(t.first, t.second);
  if (t < s) std::swap(s, t);
  const auto u = Minus(s.second, s.first), v = Minus(t.second, t.first);
  const auto w = Minus(t.first, s.first);
  const double uu = Dot(u, u), vv = Dot(v, v), uv = Dot(u, v), uw = Dot(u, w), vw = Dot(v, w);
  const double det = SquaredCross(u, v);
  const double limit2 = limit * limit;
  // Far from parallel the nearest positions are well determined.
  constexpr double kParallel = 1e-6;
  if (det > kParallel * uu * vv) {
    const double at_s = (uw * vv - uv * vw) / det, at_t = (uv * uw - uu * vw) / det;
    if (!(at_s > 0 && at_s < 1 && at_t > 0 && at_t < 1)) return false;
    const double volume = w[0] * (u[1] * v[2] - u[2] * v[1]) + w[1] * (u[2] * v[0] - u[0] * v[2]) +
                          w[2] * (u[0] * v[1] - u[1] * v[0]);
    return volume * volume < limit2 * det;
  }
  // Otherwise a search: the distance to t is convex along s, with an error of an ulp.
  double from = 0, to = 1;
  for (int i = 0; i < 100; ++i) {
    const double third = (to - from) / 3;
    std::array<double, 2> distance;
    for (int k = 0; k < 2; ++k) {
      const double at = k == 0 ? from + third : to - third;
      Point3 p;
      for (int j = 0; j < 3; ++j) p[j] = s.first[j] + at * u[j];
      distance[k] = SquaredDistanceToSegment(p, t.first, t.second);
      if (distance[k] < limit2) return true;
    }
    (distance[0] < distance[1] ? to : from) = distance[0] < distance[1] ? to - third : from + third;
  }
  return false;
}

}  // namespace

bool AreAtClearAngle(const Point2& apex, const Point2& a, const Point2& b) {
  const auto u = Minus(a, apex), w = Minus(b, apex);
  // Far above all rounding errors.
  return Dot(u, w) <= 0 || SquaredCross(u, w) > 4 * kLeastSine2 * (Dot(u, u) * Dot(w, w));
}

double CloseLimit(const MeshOptions& options) { return LeastDistance(options); }

template <int D>
bool IsNear(const Point<D>& p, const Point<D>& a, const Point<D>& b, double limit) {
  const Point<D>& lo = b < a ? b : a;
  const Point<D>& hi = b < a ? a : b;
  const auto d = Minus(hi, lo), w = Minus(p, lo);
  const double length2 = Dot(d, d);
  const double along = Dot(d, w);
  const double limit2 = limit * limit;
  if (along <= 0) return Dot(w, w) < limit2;
  if (along >= length2) return SquaredDistance(p, hi) < limit2;
  return SquaredCross(d, w) < limit2 * length2;
}

template <int D>
Conflict Between(const PointFeature<D>& p, const PointFeature<D>& q, double limit) {
  if (p.p == q.p) return Conflict::kDuplicatePoint;
  if (!IsOn(ValidationTerm::kPointsApart)) return Conflict::kNone;
  return SquaredDistance(p.p, q.p) < limit * limit ? Conflict::kTooClose : Conflict::kNone;
}

template <int D>
Conflict Between(const PointFeature<D>& p, const SegmentFeature<D>& s, double limit) {
  if (p.id == s.p_id || p.id == s.q_id) return Conflict::kNone;
  if (InRange(s.p, s.q, p.p) && AreCollinear(s.p, s.q, p.p)) {
    return IsOn(ValidationTerm::kPointOffSegment) ? Conflict::kPointOnSegment : Conflict::kNone;
  }
  if (!IsOn(ValidationTerm::kPointFarFromSegment)) return Conflict::kNone;
  return IsNear(p.p, s.p, s.q, limit) ? Conflict::kTooClose : Conflict::kNone;
}

template <int D>
Conflict Between(const SegmentFeature<D>& s, const SegmentFeature<D>& t,
                 [[maybe_unused]] double limit) {
  const bool pp = s.p_id == t.p_id, qq = s.q_id == t.q_id;
  const bool pq = s.p_id == t.q_id, qp = s.q_id == t.p_id;
  if ((pp && qq) || (pq && qp)) {
    return s.IsOfPolygon() || t.IsOfPolygon() ? Conflict::kNone : Conflict::kDuplicateSegment;
  }
  if (pp) return AtSharedEnd(s.p, s.q, t.q);
  if (qq) return AtSharedEnd(s.q, s.p, t.p);
  if (pq) return AtSharedEnd(s.p, s.q, t.p);
  if (qp) return AtSharedEnd(s.q, s.p, t.q);
  const Conflict conflict = Disjoint(s.p, s.q, t.p, t.q);
  if constexpr (D == 3) {
    if (conflict == Conflict::kNone && IsOn(ValidationTerm::kSegmentsPassApart) &&
        PassNear({s.p, s.q}, {t.p, t.q}, limit)) {
      return Conflict::kTooClose;
    }
  }
  return conflict;
}

CircleSide SideOfCircle(const PointFeature<2>& p, const SegmentFeature<2>& s) {
  if (p.id == s.p_id || p.id == s.q_id || !IsOn(ValidationTerm::kCirclesAreEmpty)) {
    return CircleSide::kOutside;
  }
  const int sign = geometry::DiametralBallSign(s.p, s.q, p.p);
  return sign < 0 ? CircleSide::kInside : sign == 0 ? CircleSide::kOn : CircleSide::kOutside;
}

bool MayEncroach(const SegmentFeature<2>& f, const SegmentFeature<2>& s, double limit) {
  if (!s.unsplit || f.unsplit || f.is_marked || !IsOn(ValidationTerm::kNoneCrossesCircles)) return false;
  const bool at_p = s.p_id == f.p_id || s.p_id == f.q_id,
             at_q = s.q_id == f.p_id || s.q_id == f.q_id;
  if (at_p && at_q) return false;  // one edge
  if (at_p || at_q) {
    // Vertices of f are far enough from the end for a millionth of a degree not to matter.
    constexpr double kHair2 = 1e-16;
    const Point2& apex = at_p ? s.p : s.q;
    const auto u = Minus(at_p ? s.q : s.p, apex);
    const auto w = Minus(f.p == apex ? f.q : f.p, apex);
    const double d = Dot(u, w);
    return d > 0 && d * d > kHair2 * (Dot(u, u) * Dot(w, w));
  }
  const bool is_forward = f.p < f.q;
  const double reach = std::sqrt(SquaredDistance(s.p, s.q)) / 2 * kWider + limit;
  return geometry::SquaredDistance(geometry::Midpoint(s.p, s.q), is_forward ? f.p : f.q,
                                   is_forward ? f.q : f.p) < reach * reach;
}

template bool IsNear(const Point2&, const Point2&, const Point2&, double);
template bool IsNear(const Point3&, const Point3&, const Point3&, double);
template Conflict Between(const PointFeature<2>&, const PointFeature<2>&, double);
template Conflict Between(const PointFeature<3>&, const PointFeature<3>&, double);
template Conflict Between(const PointFeature<2>&, const SegmentFeature<2>&, double);
template Conflict Between(const PointFeature<3>&, const SegmentFeature<3>&, double);
template Conflict Between(const SegmentFeature<2>&, const SegmentFeature<2>&, double);
template Conflict Between(const SegmentFeature<3>&, const SegmentFeature<3>&, double);

}  // namespace dynmesh::plc
