#include "core/meshing/planar_star.h"

#include <utility>

namespace dynmesh::meshing {

// w = (|b|^2 a^perp - |a|^2 b^perp) / (2 a x b), as seen from v. Its error, relative to
// S = (|b||a|^2 + |a||b|^2) / (2 a x b) >= |w|:
// 1. each product is right to 2 ulps;
// 2. the sums add 4;
// 3. the quotient adds as many as a x b has lost, T = |a||b| / (a x b).
void PlanarStar::ComputeCorner(int i) {
  Neighbour& a = ring_[i];
  const Neighbour& b = ring_[Next(i)];
  a.verified = false;
  const double cross = a.d[0] * b.d[1] - a.d[1] * b.d[0];
  if (!(cross > 0)) {
    a.w = {0, 0};
    a.r2 = INFINITY;
    a.error = INFINITY;
    return;
  }
  const double scale = 0.5 / cross;
  a.w[0] = (b.d[1] * a.d2 - a.d[1] * b.d2) * scale;
  a.w[1] = (a.d[0] * b.d2 - b.d[0] * a.d2) * scale;
  a.r2 = a.w[0] * a.w[0] + a.w[1] * a.w[1];
  const double la = std::fabs(a.d[0]) + std::fabs(a.d[1]),
               lb = std::fabs(b.d[0]) + std::fabs(b.d[1]);
  const double s = (lb * a.d2 + la * b.d2) * scale;
  a.error = 2e-15 * s * (1 + 2 * la * lb * scale);
}

// True if certainly no corner is in conflict with q. Else *at is the corner that reaches farthest
// towards q. Half of the queries have no conflict, and mostly the corners' reach towards q shows
// it. One pass without branches. If nothing is known of a corner, the result is false.
bool PlanarStar::IsClearOfCorners(const Point2& q, int* at) const {
  const double x = q[0] - p_[0], y = q[1] - p_[1];
  // The error of Conflicts, twice: once more for the other order of the sums.
  const double near2 = (x * x + y * y) * (1 - 8e-15), slack = 2 * (std::fabs(x) + std::fabs(y));
  double farthest = -INFINITY;
  bool is_clear = true;
  for (int i = 0; i < size(); ++i) {
    const Neighbour& n = ring_[i];
    const double reach = n.w[0] * x + n.w[1] * y;
    *at = reach > farthest ? i : *at;
    farthest = reach > farthest ? reach : farthest;
    is_clear &= 2 * (reach + n.error * slack) < near2;
  }
  return is_clear;
}

// A corner in conflict with q, or -1 if there is none.
int PlanarStar::FindConflict(const Point2& q) const {
  if (is_closed_) {
    int at = 0;
    if (IsClearOfCorners(q, &at)) return -1;
    if (ring_[at].error < INFINITY && Conflicts(at, q)) return at;
  }
  const int sector = SectorOf(
      size(), [this](int i) { return std::pair(ring_[i].d[0], ring_[i].d[1]); }, q[0] - p_[0],
      q[1] - p_[1]);
  if (sector >= 0) return Conflicts(sector, q) ? sector : -1;
  for (int i = 0; i < size(); ++i) {
    if (Conflicts(i, q)) return i;
  }
  return -1;
}

bool PlanarStar::Insert(Id u, const Point2& q) {
  // The corners in conflict are consecutive. Find one, then both ends of the run.
  int first = FindConflict(q);
  if (first < 0) return false;
  int last = first;
  while (Prev(first) != last && Conflicts(Prev(first), q)) first = Prev(first);
  while (Next(last) != first && Conflicts(Next(last), q)) last = Next(last);
  // Neighbours strictly inside the run are dropped; u is inserted between its two ends.
  const int k = size();
  const int gone = (last - first + k) % k;
  if (gone == 0) {
    ring_.insert(ring_.begin() + first + 1, Neighbour{});
    const double dx = q[0] - p_[0], dy = q[1] - p_[1];
    ring_[first + 1] = {u, q, {dx, dy}, dx * dx + dy * dy, {0, 0}, 0, 0, false};
    ComputeCorner(first);
    ComputeCorner(first + 1);
    return true;
  }
  kept_.clear();
  for (int i = Next(last), n = k - gone; n > 0; --n, i = Next(i)) kept_.push_back(ring_[i]);
  ring_.swap(kept_);  // now the run's ends are the last and the first
  Push(u, q);
  ComputeCorner(size() - 2);
  ComputeCorner(size() - 1);
  return true;
}

}  // namespace dynmesh::meshing
