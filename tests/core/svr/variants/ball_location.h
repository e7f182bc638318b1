// Point location for SVR: which simplices have each uninserted point in their circumscribed balls
// (Hudson, sec. 3.1, "by circumball").
//
// By the kernel's exact conflicts: a point is in the lists of all finite simplices that its
// insertion would remove. A query looks at one list. Thread-compatible.
#ifndef DYNMESH_TESTS_CORE_SVR_VARIANTS_BALL_LOCATION_H_
#define DYNMESH_TESTS_CORE_SVR_VARIANTS_BALL_LOCATION_H_

#include <cstdint>
#include <vector>

#include "core/geometry/point.h"
#include "core/svr/kernel.h"
#include "tests/core/svr/variants/simplex_lists.h"

namespace dynmesh::svr {

template <int D>
class BallLocation : public SimplexLists<D> {
 public:
  using Point = geometry::Point<D>;

  // As of VoronoiLocation.
  BallLocation(const Kernel<D>& mesh, const Positions<D>& points) : Base(mesh, points) {}
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

  // A side of the hole that an insertion makes.
  struct Rim {
    SimplexIndex outside;  // the simplex beyond it
    int corner;            // of that one, opposite to the side
    std::uint32_t hole;    // of the simplex that will be removed: its place in holes_
  };

  void PutNew(VertexIndex q, SimplexIndex s, VertexIndex v) {
    Base::Put(q, s);
    near_[q] = v;
    ++counts_.reassigned;
  }
  void Fill(SimplexIndex s, VertexIndex v, std::uint32_t inner, std::uint32_t outer);

  std::vector<Rim> rim_;
  std::vector<std::uint32_t> holes_;  // lists of simplices that will be removed
  // Of Fill: the last call that met each point in one list; in both.
  std::uint32_t fill_ = 0;
  std::vector<std::uint32_t> met_, met_twice_;
};

// --- Implementation -------------------------------------------------------------------------

// v is the nearest vertex.
template <int D>
VertexIndex BallLocation<D>::Assign(VertexIndex p, VertexIndex v) {
  Base::Add(p, v);
  const SimplexIndex containing = Base::ContainingNear(v, points_[p]);
  Base::WalkCavity(points_[p], containing, [&](SimplexIndex s) {
    if (!mesh_.IsInfinite(s)) Base::Put(p, s);
  });
  return mesh_.vertices(containing)[0];
}

template <int D>
VertexIndex BallLocation<D>::FindIn(SimplexIndex s, const Ball<D>& ball, double radius) {
  if (left_ == 0) return kNone;
  ++counts_.queries;
  for (std::uint32_t e = Base::FirstOf(s); e != kNone; e = entries_[e].next) {
    ++counts_.looked_at;
    const VertexIndex p = entries_[e].p;
    if (geometry::SquaredDistance(points_[p], ball.centre) < radius * radius) return p;
  }
  return kNone;
}

template <int D>
void BallLocation<D>::Inserting(const Point& p, SimplexIndex conflicting) {
  if (left_ == 0) return;
  Base::WalkCavity(p, conflicting, [&](SimplexIndex s) {
    const auto hole = static_cast<std::uint32_t>(holes_.size());
    holes_.push_back(Base::TakeList(s));
    for (int i = 0; i <= D; ++i) {
      const auto beyond = mesh_.Opposite({s, i});
      if (mesh_.Conflicts(beyond.simplex, p)) continue;
      rim_.push_back({beyond.simplex, beyond.index, hole});
    }
  });
}

template <int D>
void BallLocation<D>::Inserted(VertexIndex v, bool was_waiting) {
  if (was_waiting) --left_;
  for (const Rim& rim : rim_) {
    const SimplexIndex s = mesh_.Opposite({rim.outside, rim.corner}).simplex;
    if (!mesh_.IsInfinite(s)) Fill(s, v, holes_[rim.hole], Base::FirstOf(rim.outside));
  }
  rim_.clear();
  for (std::uint32_t e : holes_) {
    while (e != kNone) {
      const std::uint32_t next = entries_[e].next;
      Base::Free(e);
      e = next;
    }
  }
  holes_.clear();
}

// Of simplex s with the new vertex v. `inner` and `outer`: lists of the simplices that had the side
// opposite to v, one removed, one beyond it. The three spheres have the corners of that side in
// common, and that of s is between the others: its ball is a part of their union, and their
// intersection is a part of it.
template <int D>
void BallLocation<D>::Fill(SimplexIndex s, VertexIndex v, std::uint32_t inner,
                           std::uint32_t outer) {
  ++fill_;
  if (met_.size() < points_.size()) {
    met_.resize(points_.size() * 3 / 2, 0);
    met_twice_.resize(met_.size(), 0);
  }
  for (std::uint32_t e = inner; e != kNone; e = entries_[e].next) met_[entries_[e].p] = fill_;
  for (std::uint32_t e = outer; e != kNone; e = entries_[e].next) {
    const VertexIndex q = entries_[e].p;
    ++counts_.looked_at;
    if (met_[q] == fill_) {
      met_twice_[q] = fill_;
      PutNew(q, s, v);
      continue;
    }
    ++counts_.predicates;
    if (mesh_.Conflicts(s, points_[q])) PutNew(q, s, v);
  }
  for (std::uint32_t e = inner; e != kNone; e = entries_[e].next) {
    const VertexIndex q = entries_[e].p;
    ++counts_.looked_at;
    if (q == v || met_twice_[q] == fill_) continue;
    ++counts_.predicates;
    if (mesh_.Conflicts(s, points_[q])) PutNew(q, s, v);
  }
}

}  // namespace dynmesh::svr

#endif  // DYNMESH_TESTS_CORE_SVR_VARIANTS_BALL_LOCATION_H_
