// The triangles of a triangulation: their vertices, neighbours and circles, and walks over them.
//
// Beyond the hull there is one symbolic vertex, kInfinite, so that every edge has two triangles.
// Thread-compatible. Memory is 64 bytes per triangle, 20 per vertex index.
#ifndef DYNMESH_CORE_DELAUNAY_TRIANGLE_TABLE_H_
#define DYNMESH_CORE_DELAUNAY_TRIANGLE_TABLE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/large_vector.h"
#include "core/geometry/point.h"

namespace dynmesh::delaunay {

// What readers see of a DelaunayTriangulation, which alone changes it.
class TriangleTable {
 public:
  using VertexIndex = std::uint32_t;   // chosen by the caller, dense, below 2^31
  using SimplexIndex = std::uint32_t;  // below 2^30
  static constexpr VertexIndex kInfinite = ~VertexIndex{0};
  static constexpr SimplexIndex kNone = ~SimplexIndex{0};

  // A triangle and one of its corners: the position of a walk that turns counter-clockwise around a
  // vertex.
  struct Corner {
    SimplexIndex simplex;
    int index;  // the vertex is the triangle's corner `index`
    friend bool operator==(const Corner&, const Corner&) = default;
  };

  bool Contains(VertexIndex v) const { return v < incident_.size() && incident_[v] != kNone; }
  const geometry::Point2& position(VertexIndex v) const { return points_[v]; }
  std::size_t vertex_count() const { return vertex_count_; }  // without kInfinite
  std::size_t simplex_count() const {                         // finite ones only, by Euler
    return vertex_count_ == 0 ? 0 : 2 * vertex_count_ - 2 - hull_count_;
  }

  // Some corner at v (also for kInfinite). NextAround turns counter-clockwise about the vertex.
  Corner Around(VertexIndex v) const {
    return ToCorner(v == kInfinite ? infinite_incident_ : incident_[v]);
  }
  Corner NextAround(Corner c) const {
    const Corner across = Opposite({c.simplex, NextIndex(c.index)});
    return {across.simplex, NextIndex(across.index)};
  }
  Corner PreviousAround(Corner c) const {
    const Corner across = Opposite({c.simplex, PreviousIndex(c.index)});
    return {across.simplex, PreviousIndex(across.index)};
  }
  // All corners at v, counter-clockwise. Walks both ways at once: each step waits for the memory
  // read by the step before, but not for the other way's.
  void CornersAround(VertexIndex v, std::vector<Corner>* corners) const {
    corners->clear();
    std::array<Corner, 16> behind;
    std::size_t count = 0;
    Corner ahead = Around(v), back = ahead;
    corners->push_back(ahead);
    while (true) {
      ahead = NextAround(ahead);
      if (ahead.simplex == back.simplex) break;
      corners->push_back(ahead);
      if (count == behind.size()) continue;
      back = PreviousAround(back);
      if (ahead.simplex == back.simplex) break;
      behind[count++] = back;
    }
    while (count > 0) corners->push_back(behind[--count]);
  }
  // Calls f(t) for each triangle at v.
  template <class F>
  void ForEachSimplexAround(VertexIndex v, F f) const {
    const Corner first = Around(v);
    Corner corner = first;
    do {
      f(corner.simplex);
      corner = NextAround(corner);
    } while (corner.simplex != first.simplex);
  }
  // Prefetches what a walk around v reads. Call it for each step, 0 to kPrefetchSteps - 1, with
  // some time between: each step reads what the one before has fetched. v must be present.
  static constexpr int kPrefetchSteps = 3;
  void PrefetchAround(VertexIndex v, int step) const {
    if (step == 0) {
      __builtin_prefetch(&incident_[v]);
      __builtin_prefetch(&points_[v]);
      return;
    }
    const Triangle& t = triangles_[incident_[v] >> 2];
    if (step == 1) {
      __builtin_prefetch(&t);
      return;
    }
    for (int i = 0; i < 3; ++i) {
      __builtin_prefetch(&triangles_[t.opposite[i] >> 2]);
      if (t.v[i] != kInfinite) __builtin_prefetch(&points_[t.v[i]]);
    }
  }
  // The corner that faces c across the edge opposite to c.
  Corner Opposite(Corner c) const { return ToCorner(triangles_[c.simplex].opposite[c.index]); }
  // Prefetches the triangle of Opposite(c).
  void PrefetchOpposite(Corner c) const {
    __builtin_prefetch(&triangles_[triangles_[c.simplex].opposite[c.index] >> 2]);
  }
  // Corner indices counter-clockwise in a triangle: 0 1 2 0 and back.
  static constexpr int NextIndex(int i) { return (0b00'10'01 >> (2 * i)) & 3; }
  static constexpr int PreviousIndex(int i) { return (0b01'00'10 >> (2 * i)) & 3; }

  // The triangle's other two vertices, seen from a corner: counter-clockwise from it.
  VertexIndex NextVertex(Corner c) const { return triangles_[c.simplex].v[NextIndex(c.index)]; }
  VertexIndex PreviousVertex(Corner c) const {
    return triangles_[c.simplex].v[PreviousIndex(c.index)];
  }
  // Vertices of a triangle, counter-clockwise; one may be kInfinite.
  const std::array<VertexIndex, 3>& vertices(SimplexIndex t) const { return triangles_[t].v; }
  // Also true for unused indices, so a loop below simplex_limit() needs no other test.
  bool IsInfinite(SimplexIndex t) const { return triangles_[t].HasInfinite(); }
  SimplexIndex simplex_limit() const { return static_cast<SimplexIndex>(triangles_.size()); }

  // True if inserting p, distinct from all vertices, would delete triangle t. Exact, ties by
  // coordinates.
  bool Conflicts(SimplexIndex t, const geometry::Point2& p) const {
    const Triangle& triangle = triangles_[t];
    const double dx = p[0] - triangle.center_x;
    const double dy = p[1] - triangle.center_y;
    const double power = dx * dx + dy * dy - triangle.squared_radius;
    if (power > triangle.power_error) return false;
    if (power < -triangle.power_error) return true;
    return ConflictsExactly(triangle, p);
  }

  // The circumscribed circle, rounded when t was made. Not canonical: its last bits depend on which
  // corner came first. circle_error(t) bounds the error of |x - center|^2 - squared_radius for any
  // x not far outside. It is infinite where the circle is useless (infinite or needle-like
  // triangles).
  geometry::Point2 circumcenter(SimplexIndex t) const {
    return {{triangles_[t].center_x, triangles_[t].center_y}};
  }
  double squared_circumradius(SimplexIndex t) const { return triangles_[t].squared_radius; }
  double circle_error(SimplexIndex t) const { return triangles_[t].power_error; }

  // Eight bytes of each triangle for the caller; zero in a new one.
  std::uint64_t tag(SimplexIndex t) const { return triangles_[t].tag; }
  void set_tag(SimplexIndex t, std::uint64_t tag) { triangles_[t].tag = tag; }

  // Calls f(t) for each finite triangle.
  template <class F>
  void ForEachSimplex(F f) const {
    for (SimplexIndex t = 0; t < simplex_limit(); ++t) {
      if (!IsInfinite(t)) f(t);
    }
  }

 protected:
  // A packed corner: triangle * 4 + index.
  using Code = std::uint32_t;
  static constexpr Code ToCode(SimplexIndex t, int index) {
    return t << 2 | static_cast<Code>(index);
  }
  static constexpr Corner ToCorner(Code c) { return {c >> 2, static_cast<int>(c & 3)}; }

  // One cache line. The circle answers most conflict tests with four operations; see
  // SetCircle for its error. Unused triangles have only kInfinite as vertices.
  struct alignas(64) Triangle {
    std::array<VertexIndex, 3> v;
    std::array<Code, 3> opposite;  // the corner that faces corner i across its edge
    double center_x, center_y, squared_radius, power_error;
    std::uint64_t tag;

    bool HasInfinite() const { return static_cast<std::int32_t>(v[0] | v[1] | v[2]) < 0; }
    bool IsUnused() const { return (v[0] & v[1]) == kInfinite; }
  };

  bool ConflictsExactly(const Triangle& t, const geometry::Point2& p) const;
  static void SetCircle(Triangle* t, const geometry::Point2& a, const geometry::Point2& b,
                        const geometry::Point2& c);
  static void SetNoCircle(Triangle* t);
  void Link(Code a, Code b) {
    triangles_[a >> 2].opposite[a & 3] = b;
    triangles_[b >> 2].opposite[b & 3] = a;
  }

  void AddVertex(VertexIndex v, const geometry::Point2& p);
  // Sets vertices, circle and incidences, but not the links.
  void MakeTriangle(SimplexIndex t, VertexIndex a, VertexIndex b, VertexIndex c);
  SimplexIndex AllocateTriangle();
  void FreeTriangle(SimplexIndex t);

  LargeVector<Triangle> triangles_;
  LargeVector<geometry::Point2> points_;  // by vertex
  LargeVector<Code> incident_;            // by vertex: some corner, or kNone
  Code infinite_incident_ = kNone;
  SimplexIndex free_ = kNone;  // unused triangles, linked by opposite[0]
  std::size_t free_count_ = 0;
  std::size_t vertex_count_ = 0;
  std::size_t hull_count_ = 0;  // vertices on the hull = infinite triangles
};

}  // namespace dynmesh::delaunay

#endif  // DYNMESH_CORE_DELAUNAY_TRIANGLE_TABLE_H_
