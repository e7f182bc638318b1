// The border of the domain: a grid of points and, in 2D, the segments between them.
#ifndef DYNMESH_CORE_MESHING_BORDER_H_
#define DYNMESH_CORE_MESHING_BORDER_H_

#include <array>

#include "core/geometry/border_grid.h"
#include "core/meshing/complex.h"
#include "core/meshing/input_editor.h"

namespace dynmesh::meshing {

// The corners first: a triangulation begins with them.
template <template <class> class E>
void AddSquare(Complex<2, E>& complex, InputEditor<2, E>& input) {
  constexpr int kSide = 6, kPoints = 4 * kSide;
  const PlanarRules& rules = complex.rules;
  const auto points = geometry::SquareBorder(rules.lo(), rules.hi(), kSide, rules.grid_spacing());
  std::array<VertexIndex, kPoints> border;
  for (int i = 0; i < kPoints; i += kSide) border[i] = input.AddPoint(points[i], 0);
  for (int i = 0; i < kPoints; ++i) {
    if (i % kSide == 0) {
      complex.hints.near = border[i];
    } else {
      border[i] = input.AddPoint(points[i], 0);
    }
  }
  for (int i = 0; i < kPoints; ++i) input.AddSegment(border[i], border[(i + 1) % kPoints], 0);
}

template <template <class> class E>
void AddCube(const Complex<3, E>& complex, InputEditor<3, E>& input) {
  const SpaceRules& rules = complex.rules;
  for (const geometry::Point3& p :
       geometry::CubeBorder(rules.lo(), rules.hi(), rules.grid_cells(), rules.grid_spacing())) {
    input.AddPoint(p, 0);
  }
}

template <int D, template <class> class E>
void AddBorder(Complex<D, E>& complex, InputEditor<D, E>& input) {
  if (complex.triangulation != nullptr) complex.ResetToDomain(complex.triangulation);
  if constexpr (D == 2) {
    AddSquare(complex, input);
  } else {
    AddCube(complex, input);
  }
  complex.border_only = true;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_BORDER_H_
