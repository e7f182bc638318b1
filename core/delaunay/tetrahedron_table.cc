#include "core/delaunay/tetrahedron_table.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/space_predicates.h"

namespace dynmesh::delaunay {

using geometry::Point3;

void TetrahedronTable::AddVertex(VertexIndex v, const Point3& p) {
  if (v >= records_.size()) records_.resize(v + std::size_t{1});
  records_[v].point = p;
  ++vertex_count_;
}

void TetrahedronTable::Make(SimplexIndex t, const std::array<VertexIndex, 4>& v) {
  Tetrahedron& tetrahedron = tetrahedra_[t];
  tetrahedron.v = v;
  tags_[t] = 0;
  if (tetrahedron.HasInfinite()) {
    SetNoSphere(&tetrahedron);
    ++infinite_count_;
    for (int i = 0; i < 4; ++i) {
      (v[i] == kInfinite ? infinite_incident_ : records_[v[i]].incident) = ToCode(t, i);
    }
  } else {
    SetSphere(&tetrahedron, records_[v[0]].point, records_[v[1]].point, records_[v[2]].point,
              records_[v[3]].point);
    for (int i = 0; i < 4; ++i) records_[v[i]].incident = ToCode(t, i);
  }
}

void TetrahedronTable::SetNoSphere(Tetrahedron* t) {
  t->center = {0, 0, 0};
  t->low = kNoLow;
  t->high = kNoHigh;
}

// The error of the cached sphere, u = 2^-53, to first order in u. Seen from d, with
// p = b - d, q = a - d, s = c - d, volume v = p.(q x s), N = p^2 (q x s) + q^2 (s x p) + s^2 (p x
// q), the center is w = N / 2v, its length the radius R. Let k = |p||q||s| / v >= 1.
// 1. |q_i s_j| + |q_j s_i| over the three i, j is a vector no longer than sqrt 2 |q||s|. So v errs
//    by 8u of its terms, 11.4 u k of itself.
// 2. N errs by 12u of its terms, that is by 17 u |p||q||s| (|p|+|q|+|s|). In w this is
//    8.5 u k (|p|+|q|+|s|) <= 51 u k R.
// 3. Dividing adds 2u. In all |dw| <= 65 u k R.
// 4. Adding d rounds by m u, m the sum of |center|. So the center errs by at most
//    e = 65 u k R + m u.
// 5. A test compares the computed |x - center|^2, with a relative error of 5u, to a bound. Except
//    for these errors it grows with the true distance from the true center. So an x outside comes
//    to at least R^2 - 2 R e - 5 u R^2, one inside to at most R^2 + 2 R e + e^2 + 5 u R^2.
// 6. The computed R^2 errs by 2 R (65 u k R) + 5 u R^2. Together 270 u k R^2 + 2 u R m.
// 7. Taken are 340 and 3. The extra quarter covers the terms of second order as long as the whole
//    is below R^2 / 4; beyond, the sphere is declared useless. R is bounded by the sum of |w|.
// 8. Bounds are kept as floats, moved outwards by more than their rounding, if far from where
//    floats end. Overflow, underflow and cancelled v end as NaNs or there: useless.
void TetrahedronTable::SetSphere(Tetrahedron* t, const Point3& a, const Point3& b, const Point3& c,
                                 const Point3& d) {
  constexpr double kRoundoff = 0x1p-53;
  constexpr double kLeast = 0x1p-100, kMost = 0x1p100;
  const double px = b[0] - d[0], py = b[1] - d[1], pz = b[2] - d[2];
  const double qx = a[0] - d[0], qy = a[1] - d[1], qz = a[2] - d[2];
  const double sx = c[0] - d[0], sy = c[1] - d[1], sz = c[2] - d[2];
  const double p2 = px * px + py * py + pz * pz;
  const double q2 = qx * qx + qy * qy + qz * qz;
  const double s2 = sx * sx + sy * sy + sz * sz;
  const double ux = qy * sz - qz * sy, uy = qz * sx - qx * sz, uz = qx * sy - qy * sx;
  const double volume = px * ux + py * uy + pz * uz;
  const double scale = 0.5 / volume;
  const double wx = (p2 * ux + q2 * (sy * pz - sz * py) + s2 * (py * qz - pz * qy)) * scale;
  const double wy = (p2 * uy + q2 * (sz * px - sx * pz) + s2 * (pz * qx - px * qz)) * scale;
  const double wz = (p2 * uz + q2 * (sx * py - sy * px) + s2 * (px * qy - py * qx)) * scale;
  const double r2 = wx * wx + wy * wy + wz * wz;
  t->center = {d[0] + wx, d[1] + wy, d[2] + wz};
  const double m = std::fabs(t->center[0]) + std::fabs(t->center[1]) + std::fabs(t->center[2]);
  const double radius = std::fabs(wx) + std::fabs(wy) + std::fabs(wz);
  const double k = 2 * std::sqrt(p2 * q2 * s2) * scale;
  const double error = kRoundoff * (340 * k * r2 + 3 * radius * m);
  // If the scale is negative, so is the first term; this must not pass either.
  const bool useful = scale > 0 && error < 0.25 * r2 && r2 > kLeast && r2 < kMost;
  constexpr double kOutwards = 0x1p-22;
  t->low = useful ? static_cast<float>((r2 - error) * (1 - kOutwards)) : kNoLow;
  t->high = useful ? static_cast<float>((r2 + error) * (1 + kOutwards)) : kNoHigh;
}

bool TetrahedronTable::ConflictsExactly(const Tetrahedron& t, const Point3& p) const {
  const auto point_of = [&](int i) -> const Point3& { return records_[t.v[i]].point; };
  if (!t.HasInfinite())
    return geometry::InSphere(point_of(0), point_of(1), point_of(2), point_of(3), p);
  const int infinite = t.InfiniteCorner();
  const auto& [i, j, k] = kFacet[infinite];
  const int side = geometry::Orientation(point_of(i), point_of(j), point_of(k), p);
  if (side != 0) return side > 0;
  const Tetrahedron& across = tetrahedra_[t.opposite[infinite] >> 2];
  return across.IsMarked() || Conflicts(t.opposite[infinite] >> 2, p);
}

// The visibility walk: crosses any facet that has p strictly beyond. In a Delaunay triangulation
// (of a lifted set, so with ties broken, too) it cannot cycle: the power of p falls with each step.
void TetrahedronTable::SimplicesAround(VertexIndex v, Star* star) const {
  star->Clear();
  star->Number({Around(v).simplex});
  for (std::size_t next = 0; next < star->keys().size(); ++next) {
    const Tetrahedron& t = tetrahedra_[star->keys()[next][0]];
    for (int i = 0; i < 4; ++i) {
      if (t.v[i] != v) star->Number({t.opposite[i] >> 2});
    }
  }
}

}  // namespace dynmesh::delaunay
