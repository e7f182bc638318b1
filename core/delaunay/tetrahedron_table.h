// The tetrahedra of a tetrahedralization: their vertices, neighbours and spheres, and walks over
// them. The 3D sibling of TriangleTable.
//
// Beyond the hull there is one symbolic vertex, kInfinite, so that every facet has two tetrahedra.
// Thread-compatible. Memory is 72 bytes per tetrahedron and 32 per vertex index.
#ifndef DYNMESH_CORE_DELAUNAY_TETRAHEDRON_TABLE_H_
#define DYNMESH_CORE_DELAUNAY_TETRAHEDRON_TABLE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/large_vector.h"
#include "core/delaunay/number_table.h"
#include "core/delaunay/vertex_link.h"
#include "core/geometry/point.h"

namespace dynmesh::delaunay {

// What readers see of a DelaunayTetrahedralization, which alone changes it.
class TetrahedronTable {
 public:
  using VertexIndex = std::uint32_t;   // chosen by the caller, dense, below 2^31
  using SimplexIndex = std::uint32_t;  // below 2^29
  static constexpr VertexIndex kInfinite = ~VertexIndex{0};
  static constexpr SimplexIndex kNone = ~SimplexIndex{0};

  struct Corner {
    SimplexIndex simplex;
    int index;  // the tetrahedron's corner `index`, and the facet opposite to it
    friend bool operator==(const Corner&, const Corner&) = default;
  };

  // The corners of facet i, opposite to corner i. With i behind them they turn as 0 1 2 3 do. So in
  // a finite tetrahedron Orientation(facet i, x) > 0 if x is on its side.
  static constexpr std::array<std::array<std::uint8_t, 3>, 4> kFacet = {
      {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};

  bool Contains(VertexIndex v) const {
    return v < records_.size() && records_[v].incident != kNone;
  }
  const geometry::Point3& position(VertexIndex v) const { return records_[v].point; }
  std::size_t vertex_count() const { return vertex_count_; }  // without kInfinite
  std::size_t simplex_count() const {                         // finite ones only
    return tetrahedra_.size() - free_.size() - infinite_count_;
  }

  // Some corner at v (also for kInfinite).
  Corner Around(VertexIndex v) const {
    return ToCorner(v == kInfinite ? infinite_incident_ : records_[v].incident);
  }
  // All tetrahedra at v (also for kInfinite), as keys of one number each. `star` is the caller's,
  // to be reused from call to call.
  using Star = NumberTable<1>;
  void SimplicesAround(VertexIndex v, Star* star) const;
  // Calls f(t) for each tetrahedron at v. Allocates: for use where that does not matter.
  template <class F>
  void ForEachSimplexAround(VertexIndex v, F f) const {
    Star star;
    SimplicesAround(v, &star);
    for (const auto& [t] : star.keys()) f(t);
  }
  using VertexLink = delaunay::VertexLink;
  // The link of v. kInfinite is a neighbour like others, but makes the link no closed one. What is
  // across its edges is left to link->Join(). `link` is the caller's, to be reused from call to
  // call. O(its size).
  void LinkOf(VertexIndex v, VertexLink* link) const;
  // Prefetches what a walk around v reads first. Call it for each step, 0 to kPrefetchSteps - 1,
  // with some time between. v must be present.
  static constexpr int kPrefetchSteps = 4;
  void PrefetchAround(VertexIndex v, int step) const {
    if (step == 0) {
      __builtin_prefetch(&records_[v]);
      return;
    }
    const Tetrahedron& t = tetrahedra_[records_[v].incident >> 2];
    if (step == 1) {
      __builtin_prefetch(&t);
      return;
    }
    for (int i = 0; i < 4; ++i) {
      const Tetrahedron& beside = tetrahedra_[t.opposite[i] >> 2];
      if (step == 2) {
        __builtin_prefetch(&beside);
      } else if (t.v[i] != v) {
        for (const Code code : beside.opposite) __builtin_prefetch(&tetrahedra_[code >> 2]);
      }
    }
  }
  // The corner that faces c across the facet opposite to c.
  Corner Opposite(Corner c) const { return ToCorner(tetrahedra_[c.simplex].opposite[c.index]); }

  // The vertices of the facet opposite to c, in the order of kFacet.
  std::array<VertexIndex, 3> FacetAt(Corner c) const {
    const auto& [i, j, k] = kFacet[static_cast<std::size_t>(c.index)];
    const std::array<VertexIndex, 4>& v = tetrahedra_[c.simplex].v;
    return {v[i], v[j], v[k]};
  }
  // Vertices of a tetrahedron, positively oriented; one may be kInfinite.
  const std::array<VertexIndex, 4>& vertices(SimplexIndex t) const { return tetrahedra_[t].v; }
  // Also true for unused indices, so a loop below simplex_limit() needs no other test.
  bool IsInfinite(SimplexIndex t) const { return tetrahedra_[t].HasInfinite(); }
  bool IsUnused(SimplexIndex t) const { return tetrahedra_[t].IsUnused(); }
  SimplexIndex simplex_limit() const { return static_cast<SimplexIndex>(tetrahedra_.size()); }

  // True if inserting p, distinct from all vertices, would delete tetrahedron t. Exact, ties by
  // coordinates.
  bool Conflicts(SimplexIndex t, const geometry::Point3& p) const {
    const Tetrahedron& tetrahedron = tetrahedra_[t];
    const double distance = tetrahedron.SquaredDistance(p);
    if (distance > tetrahedron.high) return false;
    if (distance < tetrahedron.low) return true;
    return ConflictsExactly(tetrahedron, p);
  }

  // True if t keeps its circumscribed sphere in doubles, so that conflicts rarely need more. False
  // if t is infinite, or flat as far as doubles can tell.
  bool HasSphere(SimplexIndex t) const { return tetrahedra_[t].low >= 0; }
  // The squared radius is between low and high. The true center is at most (high - low) /
  // sqrt(high) away from `center`. REQUIRES: HasSphere(t).
  struct Sphere {
    geometry::Point3 center;
    double low, high;
  };
  Sphere SphereOf(SimplexIndex t) const {
    const Tetrahedron& tetrahedron = tetrahedra_[t];
    return {{tetrahedron.center}, tetrahedron.low, tetrahedron.high};
  }

  // Eight bytes of each tetrahedron for the caller; zero in a new one.
  std::uint64_t tag(SimplexIndex t) const { return tags_[t]; }
  void set_tag(SimplexIndex t, std::uint64_t tag) { tags_[t] = tag; }

  // Calls f(t) for each finite tetrahedron.
  template <class F>
  void ForEachSimplex(F f) const {
    for (SimplexIndex t = 0; t < simplex_limit(); ++t) {
      if (!IsInfinite(t)) f(t);
    }
  }

 protected:
  // A packed corner: tetrahedron * 4 + index. During an insertion a facet of the cavity's surface
  // has its number + kRim instead.
  using Code = std::uint32_t;
  static constexpr Code kRim = Code{1} << 31;
  static constexpr Code ToCode(SimplexIndex t, int index) {
    return t << 2 | static_cast<Code>(index);
  }
  static constexpr Corner ToCorner(Code c) { return {c >> 2, static_cast<int>(c & 3)}; }

  // One cache line. The sphere answers most conflict tests with a few operations; see SetSphere for
  // its error. Unused ones have only kInfinite as vertices.
  struct alignas(64) Tetrahedron {
    std::array<VertexIndex, 4> v;
    std::array<Code, 4> opposite;  // the corner that faces corner i across its facet
    std::array<double, 3> center;
    float low, high;  // inside if the squared distance is below low, outside if above high

    bool HasInfinite() const { return static_cast<std::int32_t>(v[0] | v[1] | v[2] | v[3]) < 0; }
    bool IsUnused() const { return (v[0] & v[1]) == kInfinite; }
    int InfiniteCorner() const {
      return v[0] == kInfinite ? 0 : v[1] == kInfinite ? 1 : v[2] == kInfinite ? 2 : 3;
    }
    // Without branches, as all corners are equally likely. REQUIRES: u is a corner.
    int CornerOf(VertexIndex u) const {
      return static_cast<int>(v[1] == u) + 2 * static_cast<int>(v[2] == u) +
             3 * static_cast<int>(v[3] == u);
    }
    double SquaredDistance(const geometry::Point3& p) const {
      const double x = p[0] - center[0], y = p[1] - center[1], z = p[2] - center[2];
      return x * x + y * y + z * z;
    }
    // True if in the cavity that is being collected.
    bool IsMarked() const { return low == kMarkedLow; }
    void Mark() { low = kMarkedLow, high = kNoHigh; }
  };
  static constexpr float kNoLow = -1, kMarkedLow = -2;
  static constexpr float kNoHigh = __builtin_inff();

  struct VertexRecord {
    geometry::Point3 point;
    Code incident = kNone;         // some corner
    std::uint32_t number = kNone;  // number of the vertex on the rim, while the rim is linked
  };

  bool ConflictsExactly(const Tetrahedron& t, const geometry::Point3& p) const;
  static void SetSphere(Tetrahedron* t, const geometry::Point3& a, const geometry::Point3& b,
                        const geometry::Point3& c, const geometry::Point3& d);
  static void SetNoSphere(Tetrahedron* t);
  void Link(Code a, Code b) {
    tetrahedra_[a >> 2].opposite[a & 3] = b;
    tetrahedra_[b >> 2].opposite[b & 3] = a;
  }

  void AddVertex(VertexIndex v, const geometry::Point3& p);
  // Sets vertices, sphere, tag, incidences and counts, but not the links.
  void Make(SimplexIndex t, const std::array<VertexIndex, 4>& v);
  // In tetrahedron_table_link.cc.
  template <class Tables>
  bool WalkAround(VertexIndex v, Tables& tables, VertexLink* link) const;

  LargeVector<Tetrahedron> tetrahedra_;
  LargeVector<std::uint64_t> tags_;    // by tetrahedron
  LargeVector<VertexRecord> records_;  // by vertex
  std::vector<SimplexIndex> free_;     // unused tetrahedra; the last ones are reused first
  Code infinite_incident_ = kNone;
  std::size_t vertex_count_ = 0;
  std::size_t infinite_count_ = 0;  // infinite tetrahedra
};

}  // namespace dynmesh::delaunay

#endif  // DYNMESH_CORE_DELAUNAY_TETRAHEDRON_TABLE_H_
