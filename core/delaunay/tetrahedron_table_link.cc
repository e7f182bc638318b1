// The walk around a vertex, from triangle to triangle of its link.
//
// A tetrahedron is prefetched when it is found and read later, at its turn. To test whether a
// triangle is known, no tetrahedron is read: it is known if one of its edges is.
#include "core/delaunay/tetrahedron_table.h"

namespace dynmesh::delaunay {

void TetrahedronTable::LinkOf(VertexIndex v, VertexLink* link) const {
  link->is_small = WalkAround(v, link->small, link);
  if (!link->is_small) WalkAround(v, link->large, link);
}

// False if the tables are too small.
template <class Tables>
bool TetrahedronTable::WalkAround(VertexIndex v, Tables& tables, VertexLink* link) const {
  static constexpr int kNext[] = {1, 2, 0}, kPrevious[] = {2, 0, 1};
  auto& triangles = link->triangles;
  auto& crossings = link->crossings;
  triangles.clear();
  link->simplices.clear();
  tables.Begin();
  const auto add = [&](SimplexIndex t, int a, int b, int c) {
    const auto triangle = static_cast<int>(triangles.size());
    tables.Set(a, b, triangle);
    tables.Set(b, c, triangle);
    tables.Set(c, a, triangle);
    triangles.push_back({a, b, c});
    link->simplices.push_back(t);
  };
  std::size_t end = 0;
  // From the last triangle across the edge opposite to its corner k: (a, b) as seen from beyond.
  const auto cross = [&](Code beyond, std::size_t k, int a, int b) {
    __builtin_prefetch(&tetrahedra_[beyond >> 2]);
    crossings[end] = std::uint64_t{beyond} << 32 | (triangles.size() - 1) << 2 | k;
    end += tables.Has(a, b) ? 0 : 1;
  };

  if (crossings.empty()) crossings.resize(256);
  const auto [first, own] = Around(v);
  const Tetrahedron& start = tetrahedra_[first];
  // Seen from v the facet's corners turn the other way.
  const auto& [i, k, j] = kFacet[own];
  const int a = tables.Number(start.v[i]), b = tables.Number(start.v[j]),
            c = tables.Number(start.v[k]);
  add(first, a, b, c);
  cross(start.opposite[i], 0, c, b);
  cross(start.opposite[j], 1, a, c);
  cross(start.opposite[k], 2, b, a);
  for (std::size_t next = 0; next < end; ++next) {
    const auto beyond = static_cast<Code>(crossings[next] >> 32),
               from = static_cast<Code>(crossings[next]);
    const auto& left = triangles[from >> 2];
    const int d = left[kPrevious[from & 3]], e = left[kNext[from & 3]];
    if (tables.Has(d, e)) continue;
    const Tetrahedron& t = tetrahedra_[beyond >> 2];
    const int apex = tables.Number(t.v[beyond & 3]);
    if (tables.IsTooSmall()) return false;
    if (crossings.size() < end + 2) crossings.resize(2 * end);
    add(beyond >> 2, d, e, apex);
    cross(t.opposite[t.CornerOf(tables.id(d))], 0, apex, e);
    cross(t.opposite[t.CornerOf(tables.id(e))], 1, d, apex);
  }

  link->neighbours.resize(tables.count());
  link->is_closed = true;
  for (int number = 0; number < tables.count(); ++number) {
    link->neighbours[number] = tables.id(number);
    if (tables.id(number) == kInfinite) link->is_closed = false;
  }
  return true;
}

}  // namespace dynmesh::delaunay
