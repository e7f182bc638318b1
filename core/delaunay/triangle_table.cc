#include "core/delaunay/triangle_table.h"

#include <cmath>
#include <limits>

#include "core/geometry/predicates.h"

namespace dynmesh::delaunay {

using geometry::Point2;

void TriangleTable::AddVertex(VertexIndex v, const Point2& p) {
  if (v >= points_.size()) {
    points_.resize(v + std::size_t{1});
    incident_.resize(v + std::size_t{1}, kNone);
  }
  points_[v] = p;
  ++vertex_count_;
}

TriangleTable::SimplexIndex TriangleTable::AllocateTriangle() {
  if (free_ == kNone) {
    triangles_.emplace_back();
    return simplex_limit() - 1;
  }
  const SimplexIndex t = free_;
  free_ = triangles_[t].opposite[0];
  --free_count_;
  return t;
}

void TriangleTable::FreeTriangle(SimplexIndex t) {
  triangles_[t].v = {kInfinite, kInfinite, kInfinite};
  triangles_[t].opposite[0] = free_;
  free_ = t;
  ++free_count_;
}

void TriangleTable::MakeTriangle(SimplexIndex t, VertexIndex a, VertexIndex b, VertexIndex c) {
  Triangle& triangle = triangles_[t];
  triangle.v = {a, b, c};
  triangle.tag = 0;
  for (int i = 0; i < 3; ++i) {
    const VertexIndex v = triangle.v[i];
    (v == kInfinite ? infinite_incident_ : incident_[v]) = ToCode(t, i);
  }
  if (triangle.HasInfinite()) {
    SetNoCircle(&triangle);
  } else {
    SetCircle(&triangle, points_[a], points_[b], points_[c]);
  }
}

void TriangleTable::SetNoCircle(Triangle* t) {
  t->center_x = t->center_y = t->squared_radius = 0;
  t->power_error = std::numeric_limits<double>::infinity();
}

// The error of the cached circle, u = 2^-53, to first order in u. Seen from c, with
// p = a - c, q = b - c, r = p x q, the center is w = (q_y p^2 - p_y q^2, ...) / 2r, its length the
// radius R. Let k = |p||q|/r >= 1.
// 1. Coordinates of p, q err by u, p^2 by 4u. So each product of the numerator errs by 7u of
//    itself, the vector by 7u |p||q|(|p|+|q|) / 2r <= 14 u k R since |p|, |q| <= 2R.
// 2. r errs by 4u |p||q|, 4 u k of itself; scaling adds 2u. In all |dw| <= 20 u k R.
// 3. Adding c rounds by m u, m = |center_x| + |center_y|. So the center errs by at most
//    e = 20 u k R + m u. The squared radius errs by 40 u k R^2 + 2 u R^2.
// 4. For x within 2R of the true center the test errs by 4 R e for the center, the error of the
//    squared radius, 16 u R^2 for the squares and 3 u R^2 for the last difference: below
//    141 u k R^2 + 4 u R m.
// 5. Taken are 176 and 5. The extra quarter covers the terms of second order as long as the whole
//    is below R^2 / 4 (then u k < 2^-9); beyond, the circle is declared useless. R is bounded by
//    |w_x| + |w_y|, k by (p^2 + q^2) / 2r.
// 6. For x farther away, s > 2R, the true value exceeds 3/4 s^2, and the same terms come to less
//    than s^2/10. So the computed value exceeds 2 R^2 > R^2 / 4, and rightly says outside.
// 7. Overflow, underflow and cancelled r end as infinities or NaNs: useless as well.
void TriangleTable::SetCircle(Triangle* t, const Point2& a, const Point2& b, const Point2& c) {
  constexpr double kRoundoff = 0x1p-53;
  const double px = a[0] - c[0], py = a[1] - c[1];
  const double qx = b[0] - c[0], qy = b[1] - c[1];
  const double p2 = px * px + py * py, q2 = qx * qx + qy * qy;
  const double scale = 0.5 / (px * qy - py * qx);
  const double wx = (qy * p2 - py * q2) * scale, wy = (px * q2 - qx * p2) * scale;
  const double r2 = wx * wx + wy * wy;
  t->center_x = c[0] + wx;
  t->center_y = c[1] + wy;
  t->squared_radius = r2;
  const double m = std::fabs(t->center_x) + std::fabs(t->center_y);
  const double error = 176 * kRoundoff * ((p2 + q2) * scale) * r2 +
                       5 * kRoundoff * (std::fabs(wx) + std::fabs(wy)) * m;
  // If the scale is negative, so is the first term; this must not pass either.
  const bool useful = scale > 0 && error < 0.25 * r2;
  t->power_error = useful ? error : std::numeric_limits<double>::infinity();
}

bool TriangleTable::ConflictsExactly(const Triangle& t, const Point2& p) const {
  if (!t.HasInfinite()) return InCircle(points_[t.v[0]], points_[t.v[1]], points_[t.v[2]], p);
  // The "circle" of an infinite triangle is the open half-plane beyond its edge and the edge
  // itself. (p is none of the edge's ends.)
  const std::size_t i = t.v[0] == kInfinite ? 0 : t.v[1] == kInfinite ? 1 : 2;
  const Point2& a = points_[t.v[(i + 1) % 3]];
  const Point2& b = points_[t.v[(i + 2) % 3]];
  const int side = Orientation(a, b, p);
  return side > 0 || (side == 0 && (a < p) == (p < b));
}

}  // namespace dynmesh::delaunay
