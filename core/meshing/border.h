// What a mesher has before any feature: the border of the domain, which is a grid of points and, in
// 2D, the segments between them; and the region of max_edge. `Input` takes points, segments and
// sizing regions, as InputEditor does.
#ifndef DYNMESH_CORE_MESHING_BORDER_H_
#define DYNMESH_CORE_MESHING_BORDER_H_

#include <array>

#include "core/geometry/border_grid.h"
#include "core/meshing/complex.h"
#include "core/meshing/sizing_field.h"
#include "dynmesh/options.h"

namespace dynmesh::meshing {

// The corners first: a triangulation begins with them.
template <template <class> class E, class Input>
void AddSquare(const Complex<2, E>& complex, Input& input) {
  constexpr int kSide = 6, kPoints = 4 * kSide;
  const PlanarRules& rules = complex.rules;
  const auto points = geometry::SquareBorder(rules.lo(), rules.hi(), kSide, rules.grid_spacing());
  std::array<VertexIndex, kPoints> border;
  for (int i = 0; i < kPoints; i += kSide) border[i] = input.AddPoint(points[i], 0);
  for (int i = 0; i < kPoints; ++i) {
    if (i % kSide != 0) border[i] = input.AddPoint(points[i], 0);
  }
  for (int i = 0; i < kPoints; ++i) input.AddSegment(border[i], border[(i + 1) % kPoints], 0);
}

template <template <class> class E, class Input>
void AddCube(const Complex<3, E>& complex, Input& input) {
  const SpaceRules& rules = complex.rules;
  for (const geometry::Point3& p :
       geometry::CubeBorder(rules.lo(), rules.hi(), rules.grid_cells(), rules.grid_spacing())) {
    input.AddPoint(p, 0);
  }
}

template <int D, template <class> class E, class Input>
void AddBorder(Complex<D, E>& complex, Input& input) {
  if (complex.run.has_triangulation()) complex.ResetToDomain(&complex.run.triangulation());
  if constexpr (D == 2) {
    AddSquare(complex, input);
  } else {
    AddCube(complex, input);
  }
}

template <int D, class Input>
void AddMaxEdge(const MeshOptions& options, Input& input) {
  if (options.max_edge <= 0) return;
  SizingRegion<D> box;
  for (int k = 0; k < D; ++k) box.lo[k] = options.box.lo[k], box.hi[k] = options.box.hi[k];
  box.target = options.max_edge;
  input.AddSizing(box);
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_BORDER_H_
