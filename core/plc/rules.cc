#include "core/plc/rules.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/predicates.h"
#include "dynmesh/feature.h"

namespace dynmesh::plc {
namespace {

using geometry::Orientation;
using geometry::Point2;
using geometry::SquaredDistance;

constexpr double kCloseLimitUlps = 0x1p10;
// sin^2 of the least angle between segments, 0.001 degrees, less a hair.
constexpr double kAngleBound = 3.046174197557781e-10 * (1 - 1e-6);

// Of collinear a, b, x: is x on the closed segment ab? Exact.
bool InRange(const Point2& a, const Point2& b, const Point2& x) {
  for (int i = 0; i < 2; ++i) {
    if (x[i] < std::min(a[i], b[i]) || x[i] > std::max(a[i], b[i])) return false;
  }
  return true;
}

// Segments apex-a and apex-b.
Conflict AtSharedEnd(const Point2& apex, const Point2& a, const Point2& b) {
  const double ux = a[0] - apex[0], uy = a[1] - apex[1];
  const double wx = b[0] - apex[0], wy = b[1] - apex[1];
  const double d = ux * wx + uy * wy;
  // Collinear vectors are opposite or parallel, far from d = 0: its sign is right.
  if (d > 0 && Orientation(apex, a, b) == 0) return Conflict::kSegmentsOverlap;
  const double squares = (ux * ux + uy * uy) * (wx * wx + wy * wy);
  const double cross = ux * wy - uy * wx;
  if (d > 0 && cross * cross < kAngleBound * squares) return Conflict::kSmallAngle;
  return Conflict::kNone;
}

bool CollinearOverlap(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
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
  return Orientation(c, d, a) * Orientation(c, d, b) < 0 ? Conflict::kSegmentsCross
                                                         : Conflict::kNone;
}

}  // namespace

bool AreAtClearAngle(const Point2& apex, const Point2& a, const Point2& b) {
  const double ux = a[0] - apex[0], uy = a[1] - apex[1];
  const double wx = b[0] - apex[0], wy = b[1] - apex[1];
  const double squares = (ux * ux + uy * uy) * (wx * wx + wy * wy);
  const double cross = ux * wy - uy * wx;
  // Far beyond all rounding.
  return ux * wx + uy * wy <= 0 || cross * cross > 4 * kAngleBound * squares;
}

double CloseLimit(const MeshOptions& options) {
  const Box domain = DomainBox(options);
  double magnitude = 0;
  for (int i = 0; i < 2; ++i) {
    magnitude = std::max({magnitude, std::abs(domain.lo[i]), std::abs(domain.hi[i])});
  }
  return kCloseLimitUlps * std::ldexp(1.0, std::ilogb(magnitude) - 52);
}

bool IsNear(const Point2& p, const Point2& a, const Point2& b, double limit) {
  const Point2& lo = b < a ? b : a;
  const Point2& hi = b < a ? a : b;
  const double dx = hi[0] - lo[0], dy = hi[1] - lo[1];
  const double px = p[0] - lo[0], py = p[1] - lo[1];
  const double length2 = dx * dx + dy * dy;
  const double along = dx * px + dy * py;
  const double limit2 = limit * limit;
  if (along <= 0) return px * px + py * py < limit2;
  if (along >= length2) return SquaredDistance(p, hi) < limit2;
  const double cross = dx * py - dy * px;
  return cross * cross < limit2 * length2;
}

Conflict Between(const PointFeature<2>& p, const PointFeature<2>& q, double limit) {
  if (p.p == q.p) return Conflict::kDuplicatePoint;
  return SquaredDistance(p.p, q.p) < limit * limit ? Conflict::kTooClose : Conflict::kNone;
}

Conflict Between(const PointFeature<2>& p, const SegmentFeature<2>& s, double limit) {
  if (p.id == s.p_id || p.id == s.q_id) return Conflict::kNone;
  if (InRange(s.p, s.q, p.p) && Orientation(s.p, s.q, p.p) == 0) return Conflict::kPointOnSegment;
  return IsNear(p.p, s.p, s.q, limit) ? Conflict::kTooClose : Conflict::kNone;
}

Conflict Between(const SegmentFeature<2>& s, const SegmentFeature<2>& t) {
  const bool pp = s.p_id == t.p_id, qq = s.q_id == t.q_id;
  const bool pq = s.p_id == t.q_id, qp = s.q_id == t.p_id;
  if ((pp && qq) || (pq && qp)) {
    return s.IsOfPolygon() || t.IsOfPolygon() ? Conflict::kNone : Conflict::kDuplicateSegment;
  }
  if (pp) return AtSharedEnd(s.p, s.q, t.q);
  if (qq) return AtSharedEnd(s.q, s.p, t.p);
  if (pq) return AtSharedEnd(s.p, s.q, t.p);
  if (qp) return AtSharedEnd(s.q, s.p, t.q);
  return Disjoint(s.p, s.q, t.p, t.q);
}

}  // namespace dynmesh::plc
