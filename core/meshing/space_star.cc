#include "core/meshing/space_star.h"

#include <algorithm>
#include <utility>

#include "core/geometry/circumball.h"

namespace dynmesh::meshing {
namespace {

using geometry::Cross;
using geometry::Dot;
using geometry::Vector3;

}  // namespace

void SpaceStar::Begin(Id v, const Point3& p, double reach) {
  BeginLink(v, p, reach);
  corners_.resize(8);
  for (int k = 0; k < 6; ++k) NewNeighbour(kFirstGhost + k, Ghost(p, reach, k));
  // Corner m is in the octant that is negative along axis k where bit k of m is set.
  for (int m = 0; m < 8; ++m) {
    Corner& c = corners_[m];
    for (int k = 0; k < 3; ++k) {
      c.n[k] = 2 * k + (m >> k & 1);
      c.across[k] = m ^ (1 << k);
      ++neighbours_[c.n[k]].degree;
    }
    if ((0b10010110 >> m & 1) != 0) {  // an odd number of axes is reversed
      std::swap(c.n[1], c.n[2]);
      std::swap(c.across[1], c.across[2]);
    }
    ComputeCorner(m);
  }
}

int SpaceStar::NewNeighbour(Id u, const Point3& q) {
  int slot = static_cast<int>(neighbours_.size());
  if (free_neighbours_.empty()) {
    neighbours_.emplace_back();
    ids_.push_back(u);
  } else {
    slot = free_neighbours_.back();
    free_neighbours_.pop_back();
  }
  Neighbour& n = neighbours_[slot];
  n.id = ids_[slot] = u;
  n.p = q;
  n.d = {q[0] - p_[0], q[1] - p_[1], q[2] - p_[2]};
  n.d2 = Dot(n.d, n.d);
  n.degree = 0;
  return slot;
}

void SpaceStar::BeginLink(Id v, const Point3& p, double reach) {
  v_ = v;
  p_ = p;
  reach_ = reach;
  neighbours_.clear();
  ids_.clear();
  free_neighbours_.clear();
  corners_.clear();
}

void SpaceStar::AddCorner(const std::array<int, 3>& slots, const std::array<int, 3>& across) {
  Corner& corner = corners_.emplace_back();
  corner.n = slots;
  corner.across = across;
  for (const int slot : slots) ++neighbours_[slot].degree;
}

void SpaceStar::JoinCorners() {
  const std::size_t n = neighbours_.size();
  if (corner_at_.size() < n * n) corner_at_.resize(n * n);
  // The corner at directed edge (a, b). Each edge belongs to one corner, so only written entries
  // are read.
  const auto at = [&](int a, int b) -> int& {
    return corner_at_[static_cast<std::size_t>(a) * n + static_cast<std::size_t>(b)];
  };
  for (int i = 0; i < corner_count(); ++i) {
    const auto& [a, b, c] = corners_[i].n;
    at(a, b) = at(b, c) = at(c, a) = i;
  }
  for (Corner& corner : corners_) {
    const auto& [a, b, c] = corner.n;
    corner.across = {at(c, b), at(a, c), at(b, a)};
  }
}

void SpaceStar::InsertGhosts() {
  for (int k = 0; k < 6; ++k) {
    const Id ghost = kFirstGhost + static_cast<Id>(k);
    if (!Has(ghost)) Insert(ghost, Ghost(p_, reach_, k));
  }
}

void SpaceStar::Close() {
  for (int i = 0; i < corner_count(); ++i) ComputeCorner(i);
}

bool SpaceStar::IsWithinReach() const {
  return std::ranges::all_of(corners_, [this](const Corner& c) {
    const double e = c.error + 1e-9 * reach_;
    return std::ranges::all_of(c.w, [&](double w) { return std::fabs(w) + e < reach_; });
  });
}

// Computed in the order of the points: the same bits whatever neighbour the triangle begins with.
void SpaceStar::ComputeCorner(int i) {
  Corner& corner = corners_[i];
  std::array<int, 3> s = corner.n;
  int odd = 0;
  // Without branches: half of them would be mispredicted.
  const auto sort = [&](int& x, int& y) {
    const Point3 &p = neighbours_[x].p, &q = neighbours_[y].p;
    int swaps = static_cast<int>(q[0] < p[0]);
    if (q[0] == p[0]) [[unlikely]]
      swaps = static_cast<int>(q < p);
    const int change = (x ^ y) & -swaps;
    x ^= change, y ^= change, odd ^= swaps;
  };
  sort(s[0], s[1]);
  sort(s[1], s[2]);
  sort(s[0], s[1]);
  const Neighbour &a = neighbours_[s[0]], &b = neighbours_[s[1]], &c = neighbours_[s[2]];
  geometry::Circumball ball(a.d, a.d2, b.d, b.d2, c.d, c.d2, odd != 0);
  // Of nearly flat tetrahedra doubles know nothing. Decisions by the centre must not be decisions
  // by noise. There are few such tetrahedra.
  if (!(ball.error <= 1e-9 * std::sqrt(std::min({a.d2, b.d2, c.d2})))) {
    ball = geometry::ExactCircumball(p_, a.p, b.p, c.p);
  }
  corner.w = ball.w;
  corner.r2 = ball.r2;
  corner.error = ball.error;
  corner.verified = false;
  if (errors_.size() < corners_.size()) {
    for (auto& row : centres_) row.resize(corners_.size());
    errors_.resize(corners_.size());
    margins_.resize(corners_.size());
  }
  for (int k = 0; k < 3; ++k) centres_[k][i] = ball.w[k];
  errors_[i] = ball.error;
}

// Computes margins_ as in ConflictsAt, for all corners at once. True if some corner may conflict.
bool SpaceStar::MayConflict(const Point3& q) {
  const double x = q[0] - p_[0], y = q[1] - p_[1], z = q[2] - p_[2];
  const double x2 = x * x + y * y + z * z;
  const double size = 4 * (std::fabs(x) + std::fabs(y) + std::fabs(z)), error = 4e-15 * x2;
  const double *const wx = centres_[0].data(), *const wy = centres_[1].data(),
                      *const wz = centres_[2].data(), *const errors = errors_.data();
  double* const margins = margins_.data();
  const int count = corner_count();
  for (int i = 0; i < count; ++i) {
    margins[i] = (x2 - 2 * (x * wx[i] + y * wy[i] + z * wz[i])) - (error + errors[i] * size);
  }
  int near = 0;
  for (int i = 0; i < count; ++i) near += !(margins[i] > 0);
  return near > 0;
}

// REQUIRES: margins_ are those of q.
bool SpaceStar::InsertNear(Id u, const Point3& q) {
  const Vector3 x = {q[0] - p_[0], q[1] - p_[1], q[2] - p_[2]};
  const double x2 = Dot(x, x);
  conflicts_.clear();
  for (int i = 0; i < corner_count(); ++i) {
    if (!(margins_[i] > 0) && ConflictsAt(i, x, x2, q)) conflicts_.push_back(i);
  }
  if (conflicts_.empty()) return false;
  FindBorder();
  const int slot = NewNeighbour(u, q);
  starts_.resize(neighbours_.size());
  // New corners reuse the slots of those in conflict.
  const std::size_t reused = std::min(border_.size(), conflicts_.size());
  for (std::size_t j = 0; j < border_.size(); ++j) {
    const BorderEdge& e = border_[j];
    int i;
    if (j < reused) {
      i = conflicts_[j];
    } else {
      i = static_cast<int>(corners_.size());
      corners_.emplace_back();
    }
    Corner& c = corners_[i];
    c.n = {e.a, e.b, slot};
    c.across[2] = e.outside;
    corners_[e.outside].across[e.index] = i;
    starts_[e.a] = i;
    for (const int k : c.n) ++neighbours_[k].degree;
  }
  for (std::size_t j = 0; j < border_.size(); ++j) {
    const int i = starts_[border_[j].a], next = starts_[border_[j].b];
    corners_[i].across[0] = next;
    corners_[next].across[1] = i;
    ComputeCorner(i);
  }
  FreeNeighbours();
  DropLeftOver(reused);
  return true;
}

// Removes the corners in conflicts_ from their neighbours' degrees. border_ becomes the edges
// around them.
void SpaceStar::FindBorder() {
  in_conflict_.assign(corners_.size(), 0);
  for (const int i : conflicts_) in_conflict_[i] = 1;
  border_.clear();
  left_.clear();
  for (const int i : conflicts_) {
    const Corner& c = corners_[i];
    for (int k = 0; k < 3; ++k) {
      if (--neighbours_[c.n[k]].degree == 0) left_.push_back(c.n[k]);
      const int outside = c.across[k];
      if (in_conflict_[outside]) continue;
      const auto& back = corners_[outside].across;
      border_.push_back({c.n[(k + 1) % 3], c.n[(k + 2) % 3], outside,
                         back[0] == i   ? 0
                         : back[1] == i ? 1
                                        : 2});
    }
  }
}

// Frees the neighbours that FindBorder left without a corner and that have none since.
void SpaceStar::FreeNeighbours() {
  for (const int slot : left_) {
    if (neighbours_[slot].degree > 0) continue;
    neighbours_[slot].id = ids_[slot] = kNobody;
    free_neighbours_.push_back(slot);
  }
}

// Cuts ear by ear: three consecutive neighbours on the rim make a corner of the new star if no
// other on the rim conflicts with it and the removed one does.
//
// Why the rim is enough:
// 1. v's cell grows only beyond its face towards the removed neighbour.
// 2. Every other neighbour had a face of the former cell. If its face gets a part in the new space,
//    it crosses the plane of the removed face within that face. So this neighbour is on the rim.
bool SpaceStar::Remove(int slot) {
  conflicts_.clear();
  for (int i = 0; i < corner_count(); ++i) {
    const auto& n = corners_[i].n;
    if (n[0] == slot || n[1] == slot || n[2] == slot) conflicts_.push_back(i);
  }
  FindBorder();
  // Sorts the edges in the order of the rim.
  for (std::size_t j = 0; j + 1 < border_.size(); ++j) {
    const auto next =
        std::find_if(border_.begin() + static_cast<std::ptrdiff_t>(j) + 1, border_.end(),
                     [&](const BorderEdge& e) { return e.a == border_[j].b; });
    if (next == border_.end()) return false;
    std::swap(border_[j + 1], *next);
  }
  rim_.clear();
  for (const BorderEdge& e : border_) rim_.push_back(e.a);
  std::size_t made = 0;
  for (std::size_t j = 0, in_vain = 0; border_.size() > 2;) {
    if (in_vain == border_.size()) return false;
    if (j >= border_.size()) j = 0;
    if (CutEar(j, conflicts_[made], neighbours_[slot].p)) {
      ++made;
      in_vain = 0;
    } else {
      ++j, ++in_vain;
    }
  }
  const BorderEdge &e = border_[0], &f = border_[1];
  corners_[e.outside].across[e.index] = f.outside;
  corners_[f.outside].across[f.index] = e.outside;
  FreeNeighbours();
  DropLeftOver(made);
  return true;
}

// Makes a corner, in slot i, of the three neighbours on the rim from edge j on, if that is right in
// place of `removed`.
bool SpaceStar::CutEar(std::size_t j, int i, const Point3& removed) {
  const std::size_t after = j + 1 == border_.size() ? 0 : j + 1;
  const BorderEdge e = border_[j], f = border_[after];
  const std::array<int, 3> n = {e.a, e.b, f.b};
  if (geometry::Orientation(p_, neighbours_[n[0]].p, neighbours_[n[1]].p, neighbours_[n[2]].p) <=
      0) {
    return false;
  }
  Corner& corner = corners_[i];
  corner.n = n;
  ComputeCorner(i);
  const bool is_empty = std::ranges::all_of(rim_, [&](int s) {
    return s == n[0] || s == n[1] || s == n[2] || !Conflicts(i, neighbours_[s].p);
  });
  if (!is_empty || !Conflicts(i, removed)) return false;
  corner.across[2] = e.outside;
  corners_[e.outside].across[e.index] = i;
  corner.across[0] = f.outside;
  corners_[f.outside].across[f.index] = i;
  for (const int s : n) ++neighbours_[s].degree;
  border_[j] = {n[0], n[2], i, 1};
  border_.erase(border_.begin() + static_cast<std::ptrdiff_t>(after));
  return true;
}

// Drops the corners in conflicts_ after the first `reused`.
void SpaceStar::DropLeftOver(std::size_t reused) {
  // The last ones first: then no corner moves into a slot that is still to be dropped.
  std::sort(conflicts_.begin() + static_cast<std::ptrdiff_t>(reused), conflicts_.end());
  while (conflicts_.size() > reused) {
    Drop(conflicts_.back());
    conflicts_.pop_back();
  }
}

// The last corner moves into its slot.
void SpaceStar::Drop(int i) {
  const int last = static_cast<int>(corners_.size()) - 1;
  if (i != last) {
    corners_[i] = corners_[last];
    for (auto& row : centres_) row[i] = row[last];
    errors_[i] = errors_[last];
    for (const int across : corners_[i].across) {
      for (int& back : corners_[across].across) {
        if (back == last) back = i;
      }
    }
  }
  corners_.pop_back();
}

}  // namespace dynmesh::meshing
