// The checker of DelaunayTetrahedralization, for tests: every invariant by its definition.
#include <algorithm>

#include "core/delaunay/check_failure.h"
#include "core/delaunay/delaunay_tetrahedralization.h"
#include "core/geometry/space_predicates.h"

namespace dynmesh::delaunay {

using geometry::Point3;

bool DelaunayTetrahedralization::Check(std::string* why) const {
  std::size_t infinite = 0, unused = 0;
  for (SimplexIndex t = 0; t < simplex_limit(); ++t) {
    if (IsUnused(t)) {
      ++unused;
      continue;
    }
    infinite += IsInfinite(t);
    if (!CheckTetrahedron(t, why)) return false;
  }
  if (infinite != infinite_count_) {
    return Fail(why, infinite, " infinite tetrahedra, counted ", infinite_count_);
  }
  if (unused != free_.size()) return Fail(why, unused, " unused ones, listed ", free_.size());
  std::vector<SimplexIndex> listed(free_.begin(), free_.end());
  std::sort(listed.begin(), listed.end());
  if (std::adjacent_find(listed.begin(), listed.end()) != listed.end()) {
    return Fail(why, "a tetrahedron is listed twice as unused");
  }
  for (const SimplexIndex t : free_) {
    if (!IsUnused(t)) return Fail(why, "tetrahedron ", t, " is in use and listed as unused");
  }
  return CheckStars(why);
}

bool DelaunayTetrahedralization::CheckTetrahedron(SimplexIndex t, std::string* why) const {
  const Tetrahedron& tetrahedron = tetrahedra_[t];
  for (int i = 0; i < 4; ++i) {
    const VertexIndex v = tetrahedron.v[i];
    if (v != kInfinite && !Contains(v)) return Fail(why, "tetrahedron ", t, " has no vertex ", v);
    const Corner across = Opposite({t, i});
    if (across.simplex >= simplex_limit() || IsUnused(across.simplex) ||
        Opposite(across) != Corner{t, i}) {
      return Fail(why, "tetrahedron ", t, " and its neighbour at ", i, " disagree");
    }
    const auto& other = vertices(across.simplex);
    std::array<VertexIndex, 3> facet, back;
    for (std::size_t k = 0; k < 3; ++k) {
      facet[k] = tetrahedron.v[kFacet[i][k]];
      back[k] = other[kFacet[across.index][2 - k]];  // seen from the other side
    }
    std::rotate(facet.begin(), std::min_element(facet.begin(), facet.end()), facet.end());
    std::rotate(back.begin(), std::min_element(back.begin(), back.end()), back.end());
    if (facet != back) {
      return Fail(why, "tetrahedra ", t, " and ", across.simplex, " share no facet");
    }
    // Locally Delaunay everywhere implies Delaunay. For infinite tetrahedra this says that the hull
    // is convex. The cached sphere must agree with the exact test.
    const VertexIndex apex = other[across.index];
    if (apex == kInfinite) continue;
    const Point3& p = records_[apex].point;
    if (ConflictsExactly(tetrahedron, p) || Conflicts(t, p)) {
      return Fail(why, "tetrahedron ", t, " has vertex ", apex, " inside its sphere");
    }
  }
  const auto point_of = [&](int i) -> const Point3& { return records_[tetrahedron.v[i]].point; };
  if (!tetrahedron.HasInfinite() &&
      geometry::Orientation(point_of(0), point_of(1), point_of(2), point_of(3)) <= 0) {
    return Fail(why, "tetrahedron ", t, " is not positively oriented");
  }
  return true;
}

// The tetrahedra at a vertex must be one connected star with a sphere as its surface: F triangles
// with F / 2 + 2 vertices. Then the whole is a closed manifold. Euler's V - E + T = 0 (each facet
// has two tetrahedra) then says that nothing is missing.
bool DelaunayTetrahedralization::CheckStars(std::string* why) const {
  Star star;
  NumberTable<1> neighbours;
  std::size_t vertices_seen = 0, ends_of_edges = 0, corners = 0;
  const auto check_star = [&](VertexIndex v) {
    const Corner c = Around(v);
    if (c.simplex >= simplex_limit() || IsUnused(c.simplex) || vertices(c.simplex)[c.index] != v) {
      return Fail(why, "vertex ", v, " points at a wrong corner");
    }
    SimplicesAround(v, &star);
    neighbours.Clear();
    for (const auto [t] : star.keys()) {
      for (const VertexIndex u : vertices(t)) neighbours.Number({u});
    }
    const std::size_t degree = neighbours.keys().size() - 1;
    if (2 * degree != star.keys().size() + 4) {
      return Fail(why, "vertex ", v, " has ", degree, " neighbours in ", star.keys().size(),
                  " tetrahedra");
    }
    ends_of_edges += degree;
    corners += star.keys().size();
    return true;
  };
  if (!check_star(kInfinite)) return false;
  for (VertexIndex v = 0; v < records_.size(); ++v) {
    if (!Contains(v)) continue;
    ++vertices_seen;
    if (!check_star(v)) return false;
  }
  if (vertices_seen != vertex_count_) {
    return Fail(why, vertices_seen, " vertices, counted ", vertex_count_);
  }
  const std::size_t used = tetrahedra_.size() - free_.size();
  if (corners != 4 * used) return Fail(why, "the stars have ", corners, " corners");
  if (vertex_count_ + 1 + used != ends_of_edges / 2) {
    return Fail(why, "Euler: ", vertex_count_, " vertices, ", ends_of_edges / 2, " edges, ", used,
                " tetrahedra");
  }
  return true;
}

}  // namespace dynmesh::delaunay
