// The checkers of 2D triangulations, for tests: every invariant by its definition.
#include "core/delaunay/check_failure.h"
#include "core/delaunay/constrained_triangulation.h"
#include "core/delaunay/delaunay_triangulation.h"
#include "core/geometry/predicates.h"

namespace dynmesh::delaunay {

using geometry::Point2;

bool DelaunayTriangulation::Check(std::string* why) const {
  return CheckBut([](Corner) { return false; }, why);
}

bool DelaunayTriangulation::CheckBut(absl::FunctionRef<bool(Corner)> is_fixed,
                                     std::string* why) const {
  std::size_t infinite = 0, unused = 0;
  for (SimplexIndex t = 0; t < simplex_limit(); ++t) {
    if (triangles_[t].IsUnused()) {
      ++unused;
      continue;
    }
    infinite += IsInfinite(t);
    if (!CheckTriangle(t, is_fixed, why)) return false;
  }
  if (infinite != hull_count_) {
    return Fail(why, infinite, " infinite triangles, counted ", hull_count_);
  }
  if (unused != free_count_) return Fail(why, unused, " unused triangles, counted ", free_count_);
  std::size_t listed = 0;
  for (SimplexIndex t = free_; t != kNone && listed <= unused; t = triangles_[t].opposite[0]) {
    ++listed;
    if (!triangles_[t].IsUnused()) return Fail(why, "triangle ", t, " is in use and free");
  }
  if (listed != unused) return Fail(why, "free list has ", listed, " of ", unused);
  // The sphere has n + 1 vertices, one of them infinity, so 2(n + 1) - 4 triangles.
  const std::size_t used = triangles_.size() - unused;
  if (used != 2 * vertex_count_ - 2 || used - infinite != simplex_count()) {
    return Fail(why, "Euler: ", vertex_count_, " vertices, ", used, " triangles");
  }
  return CheckVertices(why);
}

bool DelaunayTriangulation::CheckTriangle(SimplexIndex t, absl::FunctionRef<bool(Corner)> is_fixed,
                                          std::string* why) const {
  const Triangle& triangle = triangles_[t];
  for (int i = 0; i < 3; ++i) {
    const VertexIndex v = triangle.v[i];
    if (v != kInfinite && !Contains(v)) return Fail(why, "triangle ", t, " has no vertex ", v);
    const Corner across = Opposite({t, i});
    if (across.simplex >= simplex_limit() || across.index > 2 ||
        triangles_[across.simplex].IsUnused() || Opposite(across) != Corner{t, i}) {
      return Fail(why, "triangle ", t, " and its neighbour at ", i, " disagree");
    }
    const auto& other = vertices(across.simplex);
    if (triangle.v[NextIndex(i)] != other[PreviousIndex(across.index)] ||
        triangle.v[PreviousIndex(i)] != other[NextIndex(across.index)]) {
      return Fail(why, "triangles ", t, " and ", across.simplex, " share no edge");
    }
    // Locally Delaunay everywhere implies Delaunay. For infinite triangles this says that the hull
    // is convex. The cached circle must agree with the exact test.
    const VertexIndex apex = other[across.index];
    if (apex == kInfinite || is_fixed({t, i})) continue;
    const Point2& p = points_[apex];
    if (ConflictsExactly(triangle, p) || Conflicts(t, p)) {
      return Fail(why, "triangle ", t, " has vertex ", apex, " inside its circle");
    }
  }
  if (!triangle.HasInfinite() &&
      Orientation(points_[triangle.v[0]], points_[triangle.v[1]], points_[triangle.v[2]]) <= 0) {
    return Fail(why, "triangle ", t, " is not counter-clockwise");
  }
  return true;
}

bool DelaunayTriangulation::CheckVertices(std::string* why) const {
  std::size_t count = 0;
  const auto check_corner = [&](VertexIndex v) {
    const Corner c = Around(v);
    return c.simplex < simplex_limit() && c.index < 3 && !triangles_[c.simplex].IsUnused() &&
           vertices(c.simplex)[c.index] == v;
  };
  if (!check_corner(kInfinite)) return Fail(why, "no corner at infinity");
  for (VertexIndex v = 0; v < incident_.size(); ++v) {
    if (!Contains(v)) continue;
    ++count;
    if (!check_corner(v)) return Fail(why, "vertex ", v, " points at a wrong corner");
  }
  if (count != vertex_count_) return Fail(why, count, " vertices, counted ", vertex_count_);
  // Degrees sum to three times the triangles only if each star is one cycle.
  std::size_t corners = 0;
  const auto add_degree = [&](VertexIndex v) {
    const Corner start = Around(v);
    Corner c = start;
    do {
      ++corners;
      c = NextAround(c);
    } while (c != start && corners <= 3 * triangles_.size());
  };
  add_degree(kInfinite);
  for (VertexIndex v = 0; v < incident_.size(); ++v) {
    if (Contains(v)) add_degree(v);
  }
  if (corners != 3 * (triangles_.size() - free_count_)) {
    return Fail(why, "the stars have ", corners, " corners");
  }
  return true;
}

bool ConstrainedTriangulation::Check(std::string* why) const {
  if (segment_count_ == 0) return DelaunayTriangulation::Check(why);
  std::size_t sides = 0;
  for (SimplexIndex t = 0; t < simplex_limit(); ++t) {
    if (triangles_[t].IsUnused()) continue;
    if (marks_[t] > 7) return Fail(why, "triangle ", t, " is marked as touched");
    for (int i = 0; i < 3; ++i) {
      sides += IsSegment(Corner{t, i});
      if (IsSegment(Corner{t, i}) != IsSegment(Opposite({t, i}))) {
        return Fail(why, "triangle ", t, " and its neighbour disagree on the segment at ", i);
      }
    }
  }
  if (sides != 2 * segment_count_) {
    return Fail(why, sides, " sides of segments, of ", segment_count_, " segments");
  }
  return CheckBut([&](Corner c) { return IsSegment(c); }, why);
}

}  // namespace dynmesh::delaunay
