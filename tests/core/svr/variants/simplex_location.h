// Point location for SVR: which simplex each uninserted point is in (Hudson, sec. 3.1, "by
// simplex").
//
// By exact orientations, so each point always is in one finite simplex. A point on a common side is
// in the one that a walk comes to first. A new vertex moves the points of the simplices that it
// removes into those around it. A query looks at the simplices that the ball may meet.
// Thread-compatible.
#ifndef DYNMESH_TESTS_CORE_SVR_VARIANTS_SIMPLEX_LOCATION_H_
#define DYNMESH_TESTS_CORE_SVR_VARIANTS_SIMPLEX_LOCATION_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/base/rounding.h"
#include "core/geometry/point.h"
#include "core/svr/kernel.h"
#include "tests/core/svr/variants/simplex_lists.h"

namespace dynmesh::svr {

template <int D>
class SimplexLocation : public SimplexLists<D> {
 public:
  using Point = geometry::Point<D>;

  // As of VoronoiLocation.
  SimplexLocation(const Kernel<D>& mesh, const Positions<D>& points) : Base(mesh, points) {}
  VertexIndex Assign(VertexIndex p, VertexIndex v);
  VertexIndex FindIn(SimplexIndex s, const Ball<D>& ball, double radius);
  void Inserting(const Point& p, SimplexIndex conflicting);
  void Inserted(VertexIndex v, bool was_waiting);

 private:
  using Base = SimplexLists<D>;
  using Base::counts_;
  using Base::entries_;
  using Base::left_;
  using Base::mesh_;
  using Base::near_;
  using Base::points_;

  // Edges whose squared sine to the others is less are not certain.
  static constexpr double kFlat = 1e-6;

  bool MayMeet(SimplexIndex s, int side, const Point& centre, double radius) const;

  std::uint32_t taken_ = kNone;  // the list of points whose simplices will be removed
};

// --- Implementation -------------------------------------------------------------------------

// Puts p into the simplex that contains it. v is the nearest vertex.
template <int D>
VertexIndex SimplexLocation<D>::Assign(VertexIndex p, VertexIndex v) {
  Base::Add(p, v);
  const SimplexIndex s = Base::ContainingNear(v, points_[p]);
  Base::Put(p, s);
  return mesh_.vertices(s)[0];
}

// Is the side, opposite to that corner, near the ball? By its box, and by the distance of its plane
// (in 2D: line). Where that is not certain, it is.
template <int D>
bool SimplexLocation<D>::MayMeet(SimplexIndex s, int side, const Point& centre,
                                 double radius) const {
  std::array<std::array<double, D>, D> from;  // from the centre to each corner of the side
  for (int i = 0, row = 0; i <= D; ++i) {
    if (i == side) continue;
    const VertexIndex v = mesh_.vertices(s)[i];
    if (v == Kernel<D>::kInfinite) return false;
    const Point& p = mesh_.position(v);
    for (int k = 0; k < D; ++k) from[row][k] = p[k] - centre[k];
    ++row;
  }
  const double reach2 = radius * radius * kWider;
  double box2 = 0;
  for (int k = 0; k < D; ++k) {
    double low = from[0][k], high = low;
    for (int i = 1; i < D; ++i) low = std::min(low, from[i][k]), high = std::max(high, from[i][k]);
    const double away = std::max({0.0, low, -high});
    box2 += away * away;
  }
  if (box2 > reach2) return false;
  // Gram and Schmidt: what remains of the first corner without the directions of the others.
  const auto dot = [](const std::array<double, D>& a, const std::array<double, D>& b) {
    double sum = 0;
    for (int k = 0; k < D; ++k) sum += a[k] * b[k];
    return sum;
  };
  for (int i = 1; i < D; ++i) {
    for (int k = 0; k < D; ++k) from[i][k] -= from[0][k];
    const double whole = dot(from[i], from[i]);
    for (int j = 1; j < i; ++j) {
      const double part = dot(from[i], from[j]) / dot(from[j], from[j]);
      for (int k = 0; k < D; ++k) from[i][k] -= part * from[j][k];
    }
    if (dot(from[i], from[i]) < kFlat * whole) return true;
  }
  const double first2 = dot(from[0], from[0]);
  for (int i = 1; i < D; ++i) {
    const double part = dot(from[0], from[i]) / dot(from[i], from[i]);
    for (int k = 0; k < D; ++k) from[0][k] -= part * from[i][k];
  }
  return dot(from[0], from[0]) <= reach2 + (kWider - 1) * first2;
}

// The simplices that the ball meets are connected, across sides that it meets. The walk begins in
// that of the centre. If the centre is outside, it begins in s, and the ball is the circumscribed
// one, which meets s.
template <int D>
VertexIndex SimplexLocation<D>::FindIn(SimplexIndex s, const Ball<D>& ball, double radius) {
  if (left_ == 0) return kNone;
  ++counts_.queries;
  SimplexIndex first = Base::Containing(s, ball.centre);
  double reach = radius;
  if (mesh_.IsInfinite(first)) first = s, reach = std::sqrt(ball.r2);
  VertexIndex found = kNone;
  Base::Walk(
      first,
      [&](SimplexIndex t) {
        for (std::uint32_t e = Base::FirstOf(t); e != kNone; e = entries_[e].next) {
          const VertexIndex p = entries_[e].p;
          ++counts_.looked_at;
          if (geometry::SquaredDistance(points_[p], ball.centre) >= radius * radius) continue;
          found = p;
          return false;
        }
        return true;
      },
      [&](SimplexIndex t, int side, SimplexIndex) { return MayMeet(t, side, ball.centre, reach); });
  return found;
}

template <int D>
void SimplexLocation<D>::Inserting(const Point& p, SimplexIndex conflicting) {
  if (left_ == 0) return;
  Base::WalkCavity(p, conflicting, [&](SimplexIndex s) {
    for (std::uint32_t e = Base::TakeList(s); e != kNone;) {
      const std::uint32_t next = entries_[e].next;
      entries_[e].next = taken_;
      taken_ = e;
      e = next;
    }
  });
}

// The simplices around v cover what was removed, and each is a cone from v. So a point is in the
// cone that contains it: a walk among them comes there over the sides that meet v.
template <int D>
void SimplexLocation<D>::Inserted(VertexIndex v, bool was_waiting) {
  if (was_waiting) --left_;
  SimplexIndex s = kNone;
  for (const SimplexIndex t : mesh_.created()) {
    if (!mesh_.IsInfinite(t)) s = t;
  }
  while (taken_ != kNone) {
    const std::uint32_t e = taken_;
    const VertexIndex q = entries_[e].p;
    taken_ = entries_[e].next;
    Base::Free(e);
    if (q == v) continue;
    ++counts_.looked_at;
    ++counts_.reassigned;
    for (bool moved = true; moved;) {
      moved = false;
      for (int i = 0; i <= D && !moved; ++i) {
        if (mesh_.vertices(s)[i] == v) continue;
        ++counts_.predicates;
        if (Base::SideOf(s, i, points_[q]) >= 0) continue;
        s = mesh_.Opposite({s, i}).simplex;
        moved = true;
      }
    }
    Base::Put(q, s);
    near_[q] = v;
  }
}

}  // namespace dynmesh::svr

#endif  // DYNMESH_TESTS_CORE_SVR_VARIANTS_SIMPLEX_LOCATION_H_
