// The Delaunay triangulation of a changing set of 2D points. Exact, and unique because ties are
// broken by coordinates (geometry/predicates.h). It is a function of the point set alone, whatever
// the order of insertions and removals.
//
// The first four points are the corners of a box that holds all others in its closed inside.
// Further points may lie on the box's sides. These may be removed like any other; only the corners
// stay. Beyond the hull there is one symbolic vertex, kInfinite, so that every edge has two
// triangles.
//
// This class holds topology only; vertices are the caller's indices. Thread-compatible. Insert and
// Remove cost O(degree) with a good hint. Memory is 64 bytes per triangle, 20 per vertex index.
#ifndef DYNMESH_CORE_MESH_DELAUNAY_TRIANGULATION_H_
#define DYNMESH_CORE_MESH_DELAUNAY_TRIANGULATION_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/large_vector.h"
#include "core/geometry/point.h"

namespace dynmesh::mesh {

class DelaunayTriangulation {
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

  // Starts over with the box that has corners lo and hi. Its corners become vertices `corners` in
  // the order (lo,lo) (hi,lo) (hi,hi) (lo,hi). lo < hi in both coordinates.
  void Reset(const geometry::Point2& lo, const geometry::Point2& hi,
             const std::array<VertexIndex, 4>& corners);

  // Makes p, distinct from all points present, vertex v (an index not in use). `near` is any
  // present vertex; the nearer, the faster. See created() and deleted() for the changes.
  void Insert(VertexIndex v, const geometry::Point2& p, VertexIndex near) {
    InsertAt(v, p, Locate(p, near));
  }

  // Insert without the walk: `conflicting` is any triangle with Conflicts(it, p).
  void InsertAt(VertexIndex v, const geometry::Point2& p, SimplexIndex conflicting);

  // n vertices have exactly 2 n - 2 triangles, infinite ones included, and there are never more
  // slots than there once were triangles. Codes have 30 bits for a triangle: enough below 2^29
  // vertices.
  static constexpr bool is_full() { return false; }

  // Removes vertex v, none of the four corners. O(degree log degree) expected.
  void Remove(VertexIndex v);

  // Inserts many points in an order that is fast whatever the input (rounds of random priority,
  // Hilbert order within a round). indices.size() == points.size(). Leaves created() and deleted()
  // empty.
  void InsertAll(std::span<const VertexIndex> indices, std::span<const geometry::Point2> points);

  bool Contains(VertexIndex v) const { return v < incident_.size() && incident_[v] != kNone; }
  const geometry::Point2& position(VertexIndex v) const { return points_[v]; }
  std::size_t vertex_count() const { return vertex_count_; }  // without kInfinite
  std::size_t simplex_count() const {                         // finite ones only, by Euler
    return vertex_count_ == 0 ? 0 : 2 * vertex_count_ - 2 - hull_count_;
  }

  // Triangles that the last Insert or Remove made / deleted, infinite ones included. Created ones
  // may reuse indices of deleted ones, so deleted ones are given by their vertices. Valid until the
  // next change. Created ones of an Insert have the new vertex as corner 2, in counter-clockwise
  // order around it.
  std::span<const SimplexIndex> created() const { return created_; }
  std::span<const std::array<VertexIndex, 3>> deleted() const { return deleted_; }
  // Their tags.
  std::span<const std::uint64_t> deleted_tags() const { return deleted_tags_; }

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

  // A triangle that contains p (closed; infinite only if p is outside the box), searched from
  // `near`. If p is no vertex, the triangle conflicts with p.
  SimplexIndex Locate(const geometry::Point2& p, VertexIndex near) const;

  // Calls f(t) for each finite triangle.
  template <class F>
  void ForEachSimplex(F f) const {
    for (SimplexIndex t = 0; t < simplex_limit(); ++t) {
      if (!IsInfinite(t)) f(t);
    }
  }

  // Reserves room for that many vertices (indices below it) without further allocation.
  void Reserve(std::size_t vertices);

  // Checks every topological and Delaunay invariant, O(size). False with `*why` set if one is
  // violated.
  bool Check(std::string* why) const;
  std::size_t bytes() const;

 private:
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

  // An edge a->b of the rim of a hole, with the hole on its left, and the corner that faces it from
  // outside.
  struct RimEdge {
    VertexIndex a, b;
    Code outside;
  };

  // A chain rim_[first..last] (by its vertices a) that is still to be filled, and the corner that
  // faces its closing edge last->first.
  struct Gap {
    std::size_t first, last;
    Code outside;
  };

  SimplexIndex LocateFrom(const geometry::Point2& p, SimplexIndex start) const;
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

  // Fills cavity_ with the triangles in conflict with p and rim_ with the edges around them.
  void FindCavity(const geometry::Point2& p, SimplexIndex start);
  void FillCavityFrom(VertexIndex v, const geometry::Point2& p);

  // Removal, in delaunay_removal.cc.
  void OpenHole(VertexIndex v);
  void CloseHullGap();
  void FillHoleByScanning();
  std::size_t FindApex(const Gap& gap) const;
  void FillHoleByTriangulating(const geometry::Point2& removed);
  SimplexIndex TakeSlot();

  // Checks, in delaunay_check.cc.
  bool CheckTriangle(SimplexIndex t, std::string* why) const;
  bool CheckVertices(std::string* why) const;

  LargeVector<Triangle> triangles_;
  LargeVector<geometry::Point2> points_;  // by vertex
  LargeVector<Code> incident_;            // by vertex: some corner, or kNone
  Code infinite_incident_ = kNone;
  SimplexIndex free_ = kNone;  // unused triangles, linked by opposite[0]
  std::size_t free_count_ = 0;
  std::size_t vertex_count_ = 0;
  std::size_t hull_count_ = 0;  // vertices on the hull = infinite triangles
  std::array<VertexIndex, 4> corners_ = {};

  std::vector<SimplexIndex> created_;
  std::vector<std::array<VertexIndex, 3>> deleted_;
  std::vector<std::uint64_t> deleted_tags_;

  // Reused from call to call to avoid allocation.
  std::vector<SimplexIndex> cavity_;
  std::vector<RimEdge> rim_;
  std::vector<Code> stack_;
  std::vector<Gap> gaps_;
};

}  // namespace dynmesh::mesh

#endif  // DYNMESH_CORE_MESH_DELAUNAY_TRIANGULATION_H_
