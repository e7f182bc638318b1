// Point location for SVR: which vertex each uninserted point is nearest to (Hudson, sec. 3.1, "by
// Voronoi"). With concentric shells, a vertex keeps its points by the binary exponent of the fourth
// power of their distance: radii grow by 2^(1/4). Without, in one list. (Shells by the exponent of
// the squared distance need a sixth more looks on a surface in 3D, at the same time.)
//
// A new vertex takes points only from its neighbours, and only from shells that it can reach. A
// query looks only at cells and shells that the ball meets. Thread-compatible. Counts what it looks
// at.
#ifndef DYNMESH_CORE_SVR_VORONOI_LOCATION_H_
#define DYNMESH_CORE_SVR_VORONOI_LOCATION_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/rounding.h"
#include "core/geometry/point.h"
#include "core/svr/kernel.h"
#include "core/svr/location_counts.h"

namespace dynmesh::svr {

template <int D, bool kShells>
class VoronoiLocation {
 public:
  using Point = geometry::Point<D>;

  // Both must outlive this. `points`: positions by index, of vertices and of uninserted points. It
  // may grow.
  VoronoiLocation(const Kernel<D>& mesh, const Positions<D>& points)
      : mesh_(mesh), points_(points), next_(points.size(), kNone), owner_(points.size(), kNone) {}

  std::size_t left() const { return left_; }  // uninserted points
  const LocationCounts& counts() const { return counts_; }

  // Makes p a point of the cell of v, its nearest vertex. Returns a vertex that p crowds.
  VertexIndex Assign(VertexIndex p, VertexIndex v) {
    ++left_;
    if (p >= next_.size()) {
      next_.resize(points_.size(), kNone);
      owner_.resize(points_.size(), kNone);
    }
    Put(p, v, geometry::SquaredDistance(points_[p], mesh_.position(v)));
    return v;
  }
  // The vertex nearest to the uninserted point p, in whose cell it is.
  VertexIndex OwnerOf(VertexIndex p) const { return owner_[p]; }
  bool IsCrowded(VertexIndex v) const { return v < cells_.size() && cells_[v] != kNone; }
  // A point of the cell, among those of the outermost shell. REQUIRES: it is crowded.
  VertexIndex AnyOf(VertexIndex v) const { return shells_[cells_[v]].first; }

  // A point at a distance < `radius` from the centre of `ball`; kNone if there is none. `ball`: the
  // circumscribed ball of simplex s. REQUIRES: radius is less than the ball's.
  VertexIndex FindIn(SimplexIndex s, const Ball<D>& ball, double radius);

  // Before the insertion of a vertex at p. REQUIRES: the simplex conflicts with p.
  void Inserting(const Point& /*p*/, SimplexIndex /*conflicting*/) {}
  // After the insertion of v, as the kernel reports it. `was_waiting`: v was an uninserted point.
  void Inserted(VertexIndex v, bool was_waiting);

 private:
  // Points of one cell in a list: the fourth powers of their distances are in [2^exponent,
  // 2^(exponent + 1)).
  struct Shell {
    VertexIndex first = kNone;
    std::uint32_t next = kNone;  // the next shell inwards
    int exponent = 0;
    // The least and the greatest squared distance.
    double inner2 = 0, outer2 = INFINITY;
  };

  static int ExponentOf(double d2) { return kShells ? std::ilogb(d2 * d2) : 0; }
  static Shell NewShell(std::uint32_t next, int exponent) {
    if constexpr (!kShells) return {kNone, next, exponent};
    return {kNone, next, exponent, std::sqrt(std::ldexp(1.0, exponent)),
            std::sqrt(std::ldexp(1.0, exponent + 1))};
  }

  void Put(VertexIndex p, VertexIndex v, double d2);
  // Out of its list.
  void Take(VertexIndex p);
  // True at the first call for u in the current walk.
  bool IsNewInWalk(VertexIndex u) {
    if (u >= vertex_walk_.size()) vertex_walk_.resize(u + 1 + u / 2, 0);
    return std::exchange(vertex_walk_[u], 2 * walk_) / 2 != walk_;
  }
  // May the cell of u have a position in the ball? If so, u joins nearby_.
  bool MayMeet(VertexIndex u, const Ball<D>& ball, double radius);
  VertexIndex FindInCell(VertexIndex u, const Ball<D>& ball, double radius);

  const Kernel<D>& mesh_;
  const Positions<D>& points_;
  LargeVector<VertexIndex> next_;     // in the shell's list
  LargeVector<VertexIndex> owner_;    // whose cell it is in
  LargeVector<std::uint32_t> cells_;  // by vertex: the outermost shell
  LargeVector<Shell> shells_;
  std::vector<std::uint32_t> free_shells_;
  std::size_t left_ = 0;
  LocationCounts counts_;

  // Of the current walk over simplices and vertices: the number of the last walk that met each. Of
  // vertices it is doubled, plus 1 if the cell may meet the ball.
  std::uint32_t walk_ = 0;
  LargeVector<std::uint32_t> simplex_walk_, vertex_walk_;
  std::vector<SimplexIndex> stack_;
  // Vertices whose cells may meet the ball, and their squared distances from its centre.
  std::vector<std::pair<Point, double>> nearby_;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, bool kShells>
void VoronoiLocation<D, kShells>::Put(VertexIndex p, VertexIndex v, double d2) {
  if (v >= cells_.size()) cells_.resize(v + 1 + v / 2, kNone);
  const int exponent = ExponentOf(d2);
  std::uint32_t outer = kNone, shell = cells_[v];
  while (shell != kNone && shells_[shell].exponent > exponent) {
    outer = shell;
    shell = shells_[shell].next;
  }
  if (shell == kNone || shells_[shell].exponent != exponent) {
    const Shell fresh = NewShell(shell, exponent);
    if (free_shells_.empty()) {
      shell = static_cast<std::uint32_t>(shells_.size());
      shells_.push_back(fresh);
    } else {
      shell = free_shells_.back();
      free_shells_.pop_back();
      shells_[shell] = fresh;
    }
    (outer == kNone ? cells_[v] : shells_[outer].next) = shell;
  }
  next_[p] = shells_[shell].first;
  shells_[shell].first = p;
  owner_[p] = v;
}

template <int D, bool kShells>
void VoronoiLocation<D, kShells>::Take(VertexIndex p) {
  const VertexIndex v = owner_[p];
  const int exponent = ExponentOf(geometry::SquaredDistance(points_[p], mesh_.position(v)));
  std::uint32_t outer = kNone, shell = cells_[v];
  for (; shells_[shell].exponent != exponent; shell = shells_[shell].next) outer = shell;
  VertexIndex* link = &shells_[shell].first;
  while (*link != p) link = &next_[*link];
  *link = next_[p];
  if (shells_[shell].first == kNone) {
    (outer == kNone ? cells_[v] : shells_[outer].next) = shells_[shell].next;
    free_shells_.push_back(shell);
  }
  --left_;
}

// Positions of the cell are nearer to u than to another vertex w: beyond their bisector. So the
// ball reaches all these bisectors. With kMostNearby vertices w a third as many cells are walked
// through as with the corners of the ball's simplex alone.
template <int D, bool kShells>
bool VoronoiLocation<D, kShells>::MayMeet(VertexIndex u, const Ball<D>& ball, double radius) {
  constexpr std::size_t kMostNearby = 2 * (D + 1);
  const Point& p = mesh_.position(u);
  const double away2 = geometry::SquaredDistance(p, ball.centre);
  for (const auto& [w, w_away2] : nearby_) {
    const double beyond = away2 - w_away2;
    if (beyond <= 0) continue;
    const double reach2 = 4 * kWider * radius * radius * geometry::SquaredDistance(p, w);
    if (beyond * beyond > reach2) return false;
  }
  if (nearby_.size() < kMostNearby) nearby_.emplace_back(p, away2);
  return true;
}

template <int D, bool kShells>
VertexIndex VoronoiLocation<D, kShells>::FindInCell(VertexIndex u, const Ball<D>& ball,
                                                    double radius) {
  const double away = std::sqrt(geometry::SquaredDistance(mesh_.position(u), ball.centre));
  const double near = std::max(0.0, away - radius), far = away + radius;
  for (std::uint32_t shell = cells_[u]; shell != kNone; shell = shells_[shell].next) {
    if (shells_[shell].inner2 > far * far) continue;
    if (shells_[shell].outer2 < near * near) break;
    for (VertexIndex p = shells_[shell].first; p != kNone; p = next_[p]) {
      ++counts_.looked_at;
      if (geometry::SquaredDistance(points_[p], ball.centre) < radius * radius) return p;
    }
  }
  return kNone;
}

// Cells that meet the ball are connected, and those of the corners meet it. So all simplices with
// a corner whose cell meets it are connected, across sides with such a corner.
template <int D, bool kShells>
VertexIndex VoronoiLocation<D, kShells>::FindIn(SimplexIndex s, const Ball<D>& ball,
                                                double radius) {
  if (left_ == 0) return kNone;
  ++counts_.queries;
  ++walk_;
  nearby_.clear();
  if (simplex_walk_.size() < mesh_.simplex_limit()) {
    simplex_walk_.resize(mesh_.simplex_limit() * 3 / 2 + 64, 0);
  }
  simplex_walk_[s] = walk_;
  stack_.assign(1, s);
  while (!stack_.empty()) {
    const SimplexIndex t = stack_.back();
    stack_.pop_back();
    const std::array<VertexIndex, D + 1>& of_t = mesh_.vertices(t);
    unsigned meet = 0;  // bit i: corner i
    for (int i = 0; i <= D; ++i) {
      const VertexIndex u = of_t[i];
      if (u == Kernel<D>::kInfinite) continue;
      if (u >= vertex_walk_.size()) vertex_walk_.resize(u + 1 + u / 2, 0);
      std::uint32_t& met = vertex_walk_[u];
      if (met / 2 != walk_) {
        met = 2 * walk_ + (MayMeet(u, ball, radius) ? 1 : 0);
        if (met % 2 != 0 && IsCrowded(u)) {
          const VertexIndex p = FindInCell(u, ball, radius);
          if (p != kNone) return p;
        }
      }
      meet |= (met & 1u) << i;
    }
    for (int i = 0; i <= D; ++i) {
      if ((meet & ~(1u << i)) == 0) continue;  // no corner of this side
      const SimplexIndex beside = mesh_.Opposite({t, i}).simplex;
      if (simplex_walk_[beside] == walk_) continue;
      simplex_walk_[beside] = walk_;
      stack_.push_back(beside);
    }
  }
  return kNone;
}

template <int D, bool kShells>
void VoronoiLocation<D, kShells>::Inserted(VertexIndex v, bool was_waiting) {
  if (was_waiting) Take(v);
  if (left_ == 0) return;
  ++walk_;
  const Point& at = mesh_.position(v);
  for (const SimplexIndex s : mesh_.created()) {
    for (const VertexIndex u : mesh_.vertices(s)) {
      if (u == v || u == Kernel<D>::kInfinite) continue;
      if (!IsNewInWalk(u) || !IsCrowded(u)) continue;
      const Point& from = mesh_.position(u);
      const double reach2 = geometry::SquaredDistance(at, from) / 4;  // of the bisector
      std::uint32_t outer = kNone, shell = cells_[u];
      while (shell != kNone && shells_[shell].outer2 > reach2) {
        VertexIndex kept = kNone, q = shells_[shell].first;
        std::uint64_t looked_at = 0;
        while (q != kNone) {
          const VertexIndex next = next_[q];
          ++looked_at;
          const double d2 = geometry::SquaredDistance(points_[q], at);
          if (d2 < geometry::SquaredDistance(points_[q], from)) {
            ++counts_.reassigned;
            Put(q, v, d2);
          } else {
            next_[q] = kept;
            kept = q;
          }
          q = next;
        }
        counts_.looked_at += looked_at;
        shells_[shell].first = kept;
        const std::uint32_t next = shells_[shell].next;
        if (kept == kNone) {
          (outer == kNone ? cells_[u] : shells_[outer].next) = next;
          free_shells_.push_back(shell);
        } else {
          outer = shell;
        }
        shell = next;
      }
    }
  }
}

}  // namespace dynmesh::svr

#endif  // DYNMESH_CORE_SVR_VORONOI_LOCATION_H_
