// Removal of a vertex. The triangles around it are removed. The hole is filled by the Delaunay
// triangulation of the vertices on its rim. Why: in the triangulation without the vertex, the only
// new triangles are those with the vertex in their circle. These lie in the hole, so their corners
// are on the rim.
#include <algorithm>
#include <cassert>
#include <cstdint>
#include <vector>

#include "core/delaunay/delaunay_triangulation.h"
#include "core/geometry/predicates.h"

namespace dynmesh::delaunay {

using geometry::Point2;

namespace {

// Up to this degree apexes are found by scanning the rim: O(degree^2) tests. Above it the rim is
// triangulated: O(degree log degree) expected.
constexpr std::size_t kMaxScannedRim = 48;

}  // namespace

void DelaunayTriangulation::Remove(VertexIndex v) {
  assert(Contains(v));
  assert(std::find(corners_.begin(), corners_.end(), v) == corners_.end());
  OpenHole(v);
  const Point2 p = points_[v];
  incident_[v] = kNone;
  --vertex_count_;
  created_.clear();
  if (rim_.size() > kMaxScannedRim) {
    FillHoleByTriangulating(p);
  } else {
    CloseHullGap();
    FillHoleByScanning();
  }
  assert(cavity_.size() == 2);  // one vertex less, two triangles less
  for (SimplexIndex t : cavity_) FreeTriangle(t);
}

// Collects the star of v in cavity_ and deleted_, and its rim counter-clockwise in rim_.
void DelaunayTriangulation::OpenHole(VertexIndex v) {
  cavity_.clear();
  rim_.clear();
  deleted_.clear();
  deleted_tags_.clear();
  const Corner start = Around(v);
  Corner c = start;
  do {
    const Triangle& t = triangles_[c.simplex];
    const auto next = NextIndex(c.index);
    const auto previous = PreviousIndex(c.index);
    rim_.push_back({t.v[next], t.v[previous], t.opposite[c.index]});
    // Prefetches what is needed soon: the neighbour to link to, the position of the rim vertex.
    __builtin_prefetch(&triangles_[rim_.back().outside >> 2]);
    if (t.v[next] != kInfinite) __builtin_prefetch(&points_[t.v[next]]);
    cavity_.push_back(c.simplex);
    deleted_.push_back(t.v);
    deleted_tags_.push_back(t.tag);
    if (t.v[next] == kInfinite) --hull_count_;  // v had one edge to infinity
    c = NextAround(c);
  } while (c != start);
}

// Takes a triangle of the hole for reuse.
DelaunayTriangulation::SimplexIndex DelaunayTriangulation::TakeSlot() {
  const SimplexIndex t = cavity_.back();
  cavity_.pop_back();
  created_.push_back(t);
  return t;
}

// If v lay on the hull, between x and y, the hull edge is now xy, since v lay on a side of the box.
// Makes its infinite triangle. Leaves a rim of finite vertices that ends with the edge x->y.
void DelaunayTriangulation::CloseHullGap() {
  const auto from_infinity =
      std::find_if(rim_.begin(), rim_.end(), [](const RimEdge& e) { return e.a == kInfinite; });
  if (from_infinity == rim_.end()) return;
  std::rotate(rim_.begin(), from_infinity + 1, rim_.end());
  const RimEdge leave = rim_.back();  // infinity -> y
  rim_.pop_back();
  const RimEdge enter = rim_.back();  // x -> infinity
  rim_.pop_back();
  const SimplexIndex t = TakeSlot();
  MakeTriangle(t, enter.a, kInfinite, leave.b);
  Link(ToCode(t, 2), enter.outside);
  Link(ToCode(t, 0), leave.outside);
  rim_.push_back({enter.a, leave.b, ToCode(t, 1)});
}

// Fills the hole triangle by triangle: the one on the closing edge of a chain cuts the chain into
// two.
void DelaunayTriangulation::FillHoleByScanning() {
  gaps_.clear();
  gaps_.push_back({0, rim_.size() - 1, rim_.back().outside});
  while (!gaps_.empty()) {
    const Gap gap = gaps_.back();
    gaps_.pop_back();
    const std::size_t apex = FindApex(gap);
    const SimplexIndex t = TakeSlot();
    MakeTriangle(t, rim_[gap.last].a, rim_[gap.first].a, rim_[apex].a);
    Link(ToCode(t, 2), gap.outside);
    const auto fill = [&](std::size_t first, std::size_t last, Code code) {
      if (first + 1 == last) {
        Link(code, rim_[first].outside);
      } else {
        gaps_.push_back({first, last, code});
      }
    };
    fill(gap.first, apex, ToCode(t, 0));
    fill(apex, gap.last, ToCode(t, 1));
  }
}

// The vertex of the chain that makes the Delaunay triangle with its closing edge.
// 1. The circles through the ends of an edge are a pencil. Of two points left of the edge exactly
//    one lies inside the circle through the other. This orders all of them, so one pass finds the
//    least.
// 2. In the circle of the true apex there is no vertex. So it is the least, though the pass may
//    test vertices that the edge does not see.
// 3. Vertices right of the edge never win. Right of the edge, circles shrink as their third point
//    recedes. So that part of any candidate's circle is within the true apex's.
// 4. There is no vertex on the edge.
std::size_t DelaunayTriangulation::FindApex(const Gap& gap) const {
  std::size_t best = gap.first + 1;
  if (gap.last - gap.first == 2) return best;  // no choice
  const Point2& a = points_[rim_[gap.last].a];
  const Point2& b = points_[rim_[gap.first].a];
  while (Orientation(a, b, points_[rim_[best].a]) <= 0) ++best;
  for (std::size_t i = best + 1; i < gap.last; ++i) {
    if (InCircle(a, b, points_[rim_[best].a], points_[rim_[i].a])) best = i;
  }
  assert(best < gap.last);
  return best;
}

// For large degrees: triangulates the rim in the same box, inserting in random order. The triangles
// there in conflict with the removed point are exactly those that fill the hole here. Those that
// fill the hole are empty of all vertices, so they occur there, too; and either set is bounded by
// the rim.
void DelaunayTriangulation::FillHoleByTriangulating(const Point2& removed) {
  DelaunayTriangulation local;
  local.Reset(points_[corners_[0]], points_[corners_[2]], {0, 1, 2, 3});
  // Local vertex 4 + i is where rim edge i starts, unless that is a corner or infinite.
  std::vector<std::uint32_t> rim_index(rim_.size() + 4, kNone);  // by local vertex
  std::uint32_t rim_index_of_infinity = kNone;
  std::vector<VertexIndex> indices;
  std::vector<Point2> points;
  for (std::uint32_t i = 0; i < rim_.size(); ++i) {
    const VertexIndex v = rim_[i].a;
    const auto corner = std::find(corners_.begin(), corners_.end(), v);
    if (v == kInfinite) {
      rim_index_of_infinity = i;
    } else if (corner != corners_.end()) {
      rim_index[corner - corners_.begin()] = i;
    } else {
      rim_index[4 + i] = i;
      indices.push_back(4 + i);
      points.push_back(points_[v]);
    }
  }
  local.InsertAll(indices, points);
  const auto to_rim = [&](VertexIndex v) {
    return v == kInfinite ? rim_index_of_infinity : rim_index[v];
  };
  local.FindCavity(removed, local.Locate(removed, 0));

  // The tag of a local triangle is its copy here + 1; 0 is "none".
  for (SimplexIndex t : local.cavity_) local.set_tag(t, TakeSlot() + std::uint64_t{1});
  for (SimplexIndex from : local.cavity_) {
    const Triangle& source = local.triangles_[from];
    const auto t = static_cast<SimplexIndex>(source.tag - 1);
    MakeTriangle(t, rim_[to_rim(source.v[0])].a, rim_[to_rim(source.v[1])].a,
                 rim_[to_rim(source.v[2])].a);
    for (int i = 0; i < 3; ++i) {
      const Corner across = local.Opposite({from, i});
      const std::uint64_t tag = local.tag(across.simplex);
      if (tag != 0) {
        triangles_[t].opposite[i] = ToCode(static_cast<SimplexIndex>(tag - 1), across.index);
      } else {
        const VertexIndex edge_start = source.v[NextIndex(i)];
        Link(ToCode(t, i), rim_[to_rim(edge_start)].outside);
      }
    }
  }
}

}  // namespace dynmesh::delaunay
