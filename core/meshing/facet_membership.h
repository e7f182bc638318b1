// 3D: which triangles of a triangulation lie on a facet.
#ifndef DYNMESH_CORE_MESHING_FACET_MEMBERSHIP_H_
#define DYNMESH_CORE_MESHING_FACET_MEMBERSHIP_H_

#include "core/geometry/space_predicates.h"
#include "core/meshing/complex.h"

namespace dynmesh::meshing {

// True if d is on the side to which the facet's normal points, seen from triangle abc, which lies
// on the facet. Exact: d may be nearer to the facet's plane than the triangle's corners are.
template <template <class> class E>
bool IsOnNormalsSide(const Complex<3, E>& complex, const Facet& facet, VertexIndex a, VertexIndex b,
                     VertexIndex c, VertexIndex d) {
  const geometry::Point3 &p = complex.vertex(a).p, &q = complex.vertex(b).p,
                         &r = complex.vertex(c).p;
  const auto normal =
      geometry::Cross(geometry::Difference(q.c, p.c), geometry::Difference(r.c, p.c));
  const int side = geometry::Orientation(p, q, r, complex.vertex(d).p);
  return geometry::Dot(normal, facet.plane().normal) > 0 ? side > 0 : side < 0;
}

// The facet that contains triangle abc, a side of a tetrahedron with fourth corner d, seen from the
// side to which the facet's normal points; kNil if there is none. Four vertices of a facet may span
// a flat tetrahedron. Counting on one side only, the facet is covered exactly once all the same.
template <int D, template <class> class E>
FacetIndex FacetOf(const Complex<D, E>& complex, VertexIndex a, VertexIndex b, VertexIndex c,
                   VertexIndex d) {
  if constexpr (D == 3) {
    if (complex.facets.empty()) return kNil;
    const auto holds = [&](FacetIndex i) {
      const Facet& facet = complex.facets[i];
      const auto is_on = [&](VertexIndex v) { return complex.IsOnFacet(v, facet); };
      if (!is_on(a) || !is_on(b) || !is_on(c)) return false;
      if (is_on(d) || !IsOnNormalsSide(complex, facet, a, b, c, d)) return false;
      geometry::Point3 middle;
      for (int k = 0; k < 3; ++k) {
        middle[k] = (complex.vertex(a).p[k] + complex.vertex(b).p[k] + complex.vertex(c).p[k]) / 3;
      }
      return facet.IsInside(middle);
    };
    for (const VertexIndex v : {a, b, c}) {
      const Vertex<3>& vertex = complex.vertex(v);
      if (vertex.dimension == D) return kNil;
      if (vertex.dimension != 2) continue;
      const FacetIndex i = complex.facets.OfFeature(vertex.feature);
      return i != kNil && holds(i) ? i : kNil;
    }
    const VertexIndex corner = complex.vertex(a).dimension == 0 ? a : complex.SegmentOf(a).first;
    for (const FacetIndex i : complex.facets.AtCorner(corner)) {
      if (holds(i)) return i;
    }
  }
  return kNil;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_FACET_MEMBERSHIP_H_
