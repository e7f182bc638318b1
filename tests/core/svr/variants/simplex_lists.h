// Lists of uninserted points by simplex: what SimplexLocation and BallLocation have in common.
//
// A vertex is crowded if a simplex around it has points. Lists change only when an insertion
// removes their simplices, and kernels use the indices of removed simplices again: so lists are
// taken out before the insertion. Thread-compatible. Memory is 8 bytes per entry of a list.
#ifndef DYNMESH_TESTS_CORE_SVR_VARIANTS_SIMPLEX_LISTS_H_
#define DYNMESH_TESTS_CORE_SVR_VARIANTS_SIMPLEX_LISTS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/core/svr/variants/ball_predicates.h"
#include "core/geometry/point.h"
#include "core/geometry/predicates.h"
#include "core/geometry/space_predicates.h"
#include "core/svr/kernel.h"
#include "core/svr/location_counts.h"

namespace dynmesh::svr {

template <int D>
class SimplexLists {
 public:
  using Point = geometry::Point<D>;

  std::size_t left() const { return left_; }  // uninserted points
  const LocationCounts& counts() const { return counts_; }

  // The vertex nearest to the uninserted point p.
  VertexIndex OwnerOf(VertexIndex p) const { return NearestVertex<D>(mesh_, points_[p], near_[p]); }
  bool IsCrowded(VertexIndex v) const { return v < crowd_.size() && crowd_[v] != 0; }
  // A point of a simplex around v. REQUIRES: v is crowded.
  VertexIndex AnyOf(VertexIndex v) const {
    VertexIndex any = kNone;
    mesh_.ForEachSimplexAround(v, [&](SimplexIndex s) {
      if (any == kNone && FirstOf(s) != kNone) any = entries_[FirstOf(s)].p;
    });
    return any;
  }
  // Calls f(p) for each point in the list of s. For checks.
  template <class F>
  void ForEachIn(SimplexIndex s, F f) const {
    for (std::uint32_t e = FirstOf(s); e != kNone; e = entries_[e].next) f(entries_[e].p);
  }

 protected:
  // An entry of a list.
  struct Entry {
    VertexIndex p;
    std::uint32_t next;
  };

  SimplexLists(const Kernel<D>& mesh, const Positions<D>& points)
      : mesh_(mesh), points_(points), near_(points.size(), kNone) {}

  // > 0 if q is on the side of s's inside of the plane through all its corners but `corner`.
  int SideOf(SimplexIndex s, int corner, const Point& q) const {
    std::array<const Point*, D + 1> p;
    for (int i = 0; i <= D; ++i) p[i] = i == corner ? &q : &mesh_.position(mesh_.vertices(s)[i]);
    if constexpr (D == 2) return geometry::Orientation(*p[0], *p[1], *p[2]);
    if constexpr (D == 3) return geometry::Orientation(*p[0], *p[1], *p[2], *p[3]);
    return geometry::OrientationOf<D>(p);
  }
  // A walk from s over sides that have q strictly beyond them. It ends in a simplex that contains
  // q, or, if q is outside, in an infinite one. In a Delaunay triangulation no walk is endless.
  SimplexIndex Containing(SimplexIndex s, const Point& q) const {
    for (bool moved = true; moved && !mesh_.IsInfinite(s);) {
      moved = false;
      for (int i = 0; i <= D && !moved; ++i) {
        if (SideOf(s, i, q) >= 0) continue;
        s = mesh_.Opposite({s, i}).simplex;
        moved = true;
      }
    }
    return s;
  }
  SimplexIndex ContainingNear(VertexIndex v, const Point& q) const {
    SimplexIndex from = kNone;
    mesh_.ForEachSimplexAround(v, [&](SimplexIndex s) {
      if (from == kNone && !mesh_.IsInfinite(s)) from = s;
    });
    return Containing(from, q);
  }

  // Walks over the simplices that are connected with `first`, the nearest to it first. Calls
  // visit(s) for each; if that is false, ends there. Goes on across the sides for which
  // crosses(s, corner opposite to it, simplex beyond it).
  template <class Visit, class Crosses>
  void Walk(SimplexIndex first, Visit visit, Crosses crosses) {
    ++walk_;
    if (simplex_walk_.size() < mesh_.simplex_limit()) {
      simplex_walk_.resize(mesh_.simplex_limit() * 3 / 2 + 64, 0);
    }
    simplex_walk_[first] = walk_;
    queue_.assign(1, first);
    for (std::size_t next = 0; next < queue_.size(); ++next) {
      const SimplexIndex s = queue_[next];
      if (!visit(s)) return;
      for (int i = 0; i <= D; ++i) {
        const SimplexIndex beyond = mesh_.Opposite({s, i}).simplex;
        if (simplex_walk_[beyond] == walk_ || !crosses(s, i, beyond)) continue;
        simplex_walk_[beyond] = walk_;
        queue_.push_back(beyond);
      }
    }
  }
  // Over those that conflict with p. `first` does.
  template <class Visit>
  void WalkCavity(const Point& p, SimplexIndex first, Visit visit) {
    Walk(
        first,
        [&](SimplexIndex s) {
          visit(s);
          return true;
        },
        [&](SimplexIndex, int, SimplexIndex beyond) { return mesh_.Conflicts(beyond, p); });
  }

  std::uint32_t FirstOf(SimplexIndex s) const { return s < first_.size() ? first_[s] : kNone; }
  void Put(VertexIndex p, SimplexIndex s) {
    if (s >= first_.size()) first_.resize(mesh_.simplex_limit() * 3 / 2 + 64, kNone);
    if (first_[s] == kNone) {
      for (const VertexIndex v : mesh_.vertices(s)) {
        if (v >= crowd_.size()) crowd_.resize(v + 1 + v / 2, 0);
        ++crowd_[v];
      }
    }
    std::uint32_t e = free_entries_;
    if (e == kNone) {
      e = static_cast<std::uint32_t>(entries_.size());
      entries_.emplace_back();
    } else {
      free_entries_ = entries_[e].next;
    }
    entries_[e] = {p, first_[s]};
    first_[s] = e;
  }
  // Takes out the list of s. It is the caller's to Free.
  std::uint32_t TakeList(SimplexIndex s) {
    const std::uint32_t list = FirstOf(s);
    if (list == kNone) return kNone;
    for (const VertexIndex v : mesh_.vertices(s)) --crowd_[v];
    first_[s] = kNone;
    return list;
  }
  void Free(std::uint32_t e) {
    entries_[e].next = free_entries_;
    free_entries_ = e;
  }
  // p is a new uninserted point.
  void Add(VertexIndex p, VertexIndex near) {
    ++left_;
    if (p >= near_.size()) near_.resize(points_.size(), kNone);
    near_[p] = near;
  }

  const Kernel<D>& mesh_;
  const Positions<D>& points_;
  std::vector<VertexIndex> near_;     // by point: a vertex that is not far
  std::vector<std::uint32_t> first_;  // by simplex: the first entry of its list
  std::vector<Entry> entries_;
  std::uint32_t free_entries_ = kNone;
  std::vector<std::uint32_t> crowd_;  // by vertex: simplices around it that have points
  std::size_t left_ = 0;
  LocationCounts counts_;

 private:
  std::uint32_t walk_ = 0;
  std::vector<std::uint32_t> simplex_walk_;  // by simplex: the last walk that met it
  std::vector<SimplexIndex> queue_;
};

}  // namespace dynmesh::svr

#endif  // DYNMESH_TESTS_CORE_SVR_VARIANTS_SIMPLEX_LISTS_H_
