#include "core/meshing/space_star.h"

#include <algorithm>
#include <utility>

#include "core/geometry/circumball.h"

namespace dynmesh::meshing {
namespace {

using geometry::Cross;
using geometry::Dot;
using Vector = geometry::Vector3;

}  // namespace

void SpaceStar::Begin(Id v, const Point3& p, double reach) {
  v_ = v;
  p_ = p;
  reach_ = reach;
  neighbours_.clear();
  free_neighbours_.clear();
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
    if ((0b10010110 >> m & 1) != 0) {  // an odd number of axes turned round
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
  } else {
    slot = free_neighbours_.back();
    free_neighbours_.pop_back();
  }
  Neighbour& n = neighbours_[slot];
  n.id = u;
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
  free_neighbours_.clear();
  corners_.clear();
}

void SpaceStar::AddCorner(const std::array<int, 3>& slots, const std::array<int, 3>& across) {
  Corner& corner = corners_.emplace_back();
  corner.n = slots;
  corner.across = across;
  for (const int slot : slots) ++neighbours_[slot].degree;
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

// In the order of the points: the same bits whatever the link's triangle begins with.
void SpaceStar::ComputeCorner(int i) {
  Corner& corner = corners_[i];
  std::array<int, 3> s = corner.n;
  const auto less = [&](int x, int y) { return neighbours_[x].p < neighbours_[y].p; };
  bool odd = false;
  if (less(s[1], s[0])) std::swap(s[0], s[1]), odd = !odd;
  if (less(s[2], s[1])) std::swap(s[1], s[2]), odd = !odd;
  if (less(s[1], s[0])) std::swap(s[0], s[1]), odd = !odd;
  const Neighbour &a = neighbours_[s[0]], &b = neighbours_[s[1]], &c = neighbours_[s[2]];
  geometry::Circumball ball(a.d, a.d2, b.d, b.d2, c.d, c.d2, odd);
  // Of nearly flat tetrahedra doubles know nothing: what is decided by the centre must not be
  // decided by noise. There are few.
  if (!(ball.error <= 1e-9 * std::sqrt(std::min({a.d2, b.d2, c.d2})))) {
    ball = geometry::ExactCircumball(p_, a.p, b.p, c.p);
  }
  corner.w = ball.w;
  corner.r2 = ball.r2;
  corner.error = ball.error;
  corner.verified = false;
}

bool SpaceStar::Insert(Id u, const Point3& q) {
  const Vector x = {q[0] - p_[0], q[1] - p_[1], q[2] - p_[2]};
  const double x2 = Dot(x, x);
  conflicts_.clear();
  in_conflict_.assign(corners_.size(), 0);
  for (int i = 0; i < static_cast<int>(corners_.size()); ++i) {
    if (ConflictsAt(i, x, x2, q)) {
      conflicts_.push_back(i);
      in_conflict_[i] = 1;
    }
  }
  if (conflicts_.empty()) return false;
  border_.clear();
  for (const int i : conflicts_) {
    const Corner& c = corners_[i];
    for (int k = 0; k < 3; ++k) {
      --neighbours_[c.n[k]].degree;
      const int outside = c.across[k];
      if (in_conflict_[outside]) continue;
      const auto& back = corners_[outside].across;
      border_.push_back({c.n[(k + 1) % 3], c.n[(k + 2) % 3], outside,
                         back[0] == i   ? 0
                         : back[1] == i ? 1
                                        : 2});
    }
  }
  const int slot = NewNeighbour(u, q);
  starts_.resize(neighbours_.size());
  // New corners take the places of those in conflict.
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
  for (int k = 0; k < static_cast<int>(neighbours_.size()); ++k) {
    if (neighbours_[k].degree == 0 && neighbours_[k].id != kNobody) {
      neighbours_[k].id = kNobody;
      free_neighbours_.push_back(k);
    }
  }
  // What is left over, the last ones first: they move into no gap that is still to be closed.
  std::sort(conflicts_.begin() + static_cast<std::ptrdiff_t>(reused), conflicts_.end());
  while (conflicts_.size() > reused) {
    Drop(conflicts_.back());
    conflicts_.pop_back();
  }
  return true;
}

// The last corner takes its place.
void SpaceStar::Drop(int i) {
  const int last = static_cast<int>(corners_.size()) - 1;
  if (i != last) {
    corners_[i] = corners_[last];
    for (const int across : corners_[i].across) {
      for (int& back : corners_[across].across) {
        if (back == last) back = i;
      }
    }
  }
  corners_.pop_back();
}

}  // namespace dynmesh::meshing
