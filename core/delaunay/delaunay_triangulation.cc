// Construction, point location and insertion; removal and checks have files of their own.
#include "core/delaunay/delaunay_triangulation.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/delaunay/delaunay_insert_order.h"
#include "core/geometry/predicates.h"

namespace dynmesh::delaunay {

using geometry::Point2;

namespace {

constexpr std::size_t kInitialStack = 64;

}  // namespace

void DelaunayTriangulation::Reset(const Point2& lo, const Point2& hi,
                                  const std::array<VertexIndex, 4>& corners) {
  assert(lo[0] < hi[0] && lo[1] < hi[1]);
  triangles_.clear();
  points_.clear();
  incident_.clear();
  created_.clear();
  deleted_.clear();
  deleted_tags_.clear();
  free_ = kNone;
  free_count_ = 0;
  vertex_count_ = 0;
  hull_count_ = 4;
  corners_ = corners;

  const auto [a, b, c, d] = corners;
  AddVertex(a, lo);
  AddVertex(b, {{hi[0], lo[1]}});
  AddVertex(c, hi);
  AddVertex(d, {{lo[0], hi[1]}});
  // The four are cocircular; c, the greatest, is cut off.
  triangles_.resize(6);
  MakeTriangle(0, a, b, d);
  MakeTriangle(1, c, d, b);
  MakeTriangle(2, b, a, kInfinite);
  MakeTriangle(3, c, b, kInfinite);
  MakeTriangle(4, d, c, kInfinite);
  MakeTriangle(5, a, d, kInfinite);
  Link(ToCode(0, 0), ToCode(1, 0));  // bd
  Link(ToCode(0, 2), ToCode(2, 2));  // ab
  Link(ToCode(1, 1), ToCode(3, 2));  // bc
  Link(ToCode(1, 2), ToCode(4, 2));  // cd
  Link(ToCode(0, 1), ToCode(5, 2));  // da
  Link(ToCode(2, 0), ToCode(5, 1));  // a
  Link(ToCode(2, 1), ToCode(3, 0));  // b
  Link(ToCode(3, 1), ToCode(4, 0));  // c
  Link(ToCode(4, 1), ToCode(5, 0));  // d
}

void DelaunayTriangulation::Reserve(std::size_t vertices) {
  points_.reserve(vertices);
  incident_.reserve(vertices);
  triangles_.reserve(2 * vertices + 2);
}

std::size_t DelaunayTriangulation::bytes() const {
  return triangles_.size() * sizeof(Triangle) + points_.size() * sizeof(Point2) +
         incident_.size() * sizeof(Code) + created_.capacity() * sizeof(SimplexIndex) +
         deleted_.capacity() * (sizeof(deleted_[0]) + sizeof(deleted_tags_[0])) +
         cavity_.capacity() * sizeof(SimplexIndex) + rim_.capacity() * sizeof(RimEdge) +
         stack_.capacity() * sizeof(Code) + gaps_.capacity() * sizeof(Gap);
}

DelaunayTriangulation::SimplexIndex DelaunayTriangulation::Locate(const Point2& p,
                                                                  VertexIndex near) const {
  return LocateFrom(p, (Contains(near) ? incident_[near] : infinite_incident_) >> 2);
}

// The visibility walk: crosses any edge that has p strictly beyond. In a Delaunay triangulation (of
// a lifted set, so with ties broken, too) it cannot cycle: the power of p falls with each step.
DelaunayTriangulation::SimplexIndex DelaunayTriangulation::LocateFrom(const Point2& p,
                                                                      SimplexIndex start) const {
  const Triangle* t = &triangles_[start];
  if (t->HasInfinite()) {
    const std::size_t i = t->v[0] == kInfinite ? 0 : t->v[1] == kInfinite ? 1 : 2;
    t = &triangles_[t->opposite[i] >> 2];
  }
  const auto beyond = [&](int i) {
    return Orientation(points_[t->v[NextIndex(i)]], points_[t->v[PreviousIndex(i)]], p) < 0;
  };
  int i = beyond(0) ? 0 : beyond(1) ? 1 : beyond(2) ? 2 : -1;
  while (i >= 0) {
    const Corner entry = ToCorner(t->opposite[i]);
    t = &triangles_[entry.simplex];
    if (t->HasInfinite()) break;
    // p is on the near side of the edge just crossed.
    const int next = NextIndex(entry.index), previous = PreviousIndex(entry.index);
    i = beyond(next) ? next : beyond(previous) ? previous : -1;
  }
  return static_cast<SimplexIndex>(t - triangles_.data());
}

void DelaunayTriangulation::InsertAt(VertexIndex v, const Point2& p, SimplexIndex conflicting) {
  assert(!Contains(v) && v < kInfinite / 2);
  assert(Conflicts(conflicting, p));
  AddVertex(v, p);
  FindCavity(p, conflicting);
  FillCavityFrom(v, p);
}

// Depth first, each triangle's edges in counter-clockwise order, so that the rim comes out in that
// order, too. The triangles in conflict form a tree: together they are a disc with no vertex
// inside. So each is met only once and needs no mark.
void DelaunayTriangulation::FindCavity(const Point2& p, SimplexIndex start) {
  cavity_.clear();
  rim_.clear();
  cavity_.push_back(start);
  const Triangle* const triangles = triangles_.data();
  if (stack_.size() < kInitialStack) stack_.resize(kInitialStack);
  Code* stack = stack_.data();
  std::size_t depth = 0;
  for (int i : {2, 1, 0}) stack[depth++] = ToCode(start, i);
  while (depth != 0) {
    const Corner inside = ToCorner(stack[--depth]);
    const Triangle& t = triangles[inside.simplex];
    const Code code = t.opposite[inside.index];
    const Corner outside = ToCorner(code);
    if (Conflicts(outside.simplex, p)) {
      cavity_.push_back(outside.simplex);
      const int next = NextIndex(outside.index), previous = PreviousIndex(outside.index);
      stack[depth++] = ToCode(outside.simplex, previous);
      stack[depth++] = ToCode(outside.simplex, next);
      __builtin_prefetch(&triangles[triangles[outside.simplex].opposite[previous] >> 2]);
      __builtin_prefetch(&triangles[triangles[outside.simplex].opposite[next] >> 2]);
      if (depth + 2 > stack_.size()) {
        stack_.resize(2 * stack_.size());
        stack = stack_.data();
      }
    } else {
      const VertexIndex a = t.v[NextIndex(inside.index)];
      rim_.push_back({a, t.v[PreviousIndex(inside.index)], code});
      if (a != kInfinite) __builtin_prefetch(&points_[a]);  // needed when the cavity is filled
    }
  }
}

// Makes one triangle per rim edge. Corner 2 is v, corner 0 the start of the edge.
void DelaunayTriangulation::FillCavityFrom(VertexIndex v, const Point2& p) {
  const std::size_t count = rim_.size();
  assert(count == cavity_.size() + 2);
  deleted_.resize(cavity_.size());
  deleted_tags_.resize(cavity_.size());
  for (std::size_t i = 0; i < cavity_.size(); ++i) {
    deleted_[i] = triangles_[cavity_[i]].v;
    deleted_tags_[i] = triangles_[cavity_[i]].tag;
  }
  created_.swap(cavity_);
  created_.push_back(AllocateTriangle());
  created_.push_back(AllocateTriangle());

  Triangle* const triangles = triangles_.data();
  const Point2* const points = points_.data();
  Code* const incident = incident_.data();
  const SimplexIndex* const created = created_.data();
  const RimEdge* const rim = rim_.data();
  SimplexIndex previous = created[count - 1];
  for (std::size_t i = 0; i < count; ++i) {
    const SimplexIndex t = created[i];
    const SimplexIndex next = created[i + 1 == count ? 0 : i + 1];
    const RimEdge edge = rim[i];
    Triangle& triangle = triangles[t];
    triangle.v = {edge.a, edge.b, v};
    triangle.opposite = {ToCode(next, 1), ToCode(previous, 0), edge.outside};
    triangle.tag = 0;
    triangles[edge.outside >> 2].opposite[edge.outside & 3] = ToCode(t, 2);
    if (!triangle.HasInfinite()) {
      SetCircle(&triangle, points[edge.a], points[edge.b], p);
      incident[edge.a] = ToCode(t, 0);
    } else {
      SetNoCircle(&triangle);
      if (edge.a == kInfinite) {
        infinite_incident_ = ToCode(t, 0);
        ++hull_count_;  // this is v's edge to infinity
      } else {
        incident[edge.a] = ToCode(t, 0);
      }
    }
    previous = t;
  }
  incident[v] = ToCode(created[0], 2);
}

void DelaunayTriangulation::InsertAll(std::span<const VertexIndex> indices,
                                      std::span<const Point2> points) {
  assert(indices.size() == points.size());
  triangles_.reserve(triangles_.size() + 2 * points.size());
  if (!indices.empty()) {
    const std::size_t limit = *std::max_element(indices.begin(), indices.end()) + std::size_t{1};
    points_.reserve(limit);
    incident_.reserve(limit);
  }
  SimplexIndex near = infinite_incident_ >> 2;
  for (const std::uint32_t i : InsertOrder(points)) {
    InsertAt(indices[i], points[i], LocateFrom(points[i], near));
    near = created_[0];
  }
  created_.clear();
  deleted_.clear();
  deleted_tags_.clear();
}

}  // namespace dynmesh::delaunay
