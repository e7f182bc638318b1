// The border of the domain: a grid of points and, in 2D, the segments between them.
#ifndef DYNMESH_CORE_MESHING_BORDER_H_
#define DYNMESH_CORE_MESHING_BORDER_H_

#include <array>

#include "core/meshing/complex.h"
#include "core/meshing/input_editor.h"

namespace dynmesh::meshing {

// 24 points, counter-clockwise, the corners first (a triangulation begins with them).
template <template <class> class E>
void AddSquare(Complex<2, E>& complex, InputEditor<2, E>& input) {
  const PlanarRules& rules = complex.rules;
  constexpr int kSide = 6;
  const geometry::Point2 &lo = rules.lo(), &hi = rules.hi();
  const double step = rules.grid_spacing();
  std::array<VertexIndex, 4 * kSide> border;
  const auto at = [&](int side, int i) -> geometry::Point2 {
    const auto along = [&](int axis) { return i == 0 ? lo[axis] : lo[axis] + i * step; };
    const auto back = [&](int axis) { return i == 0 ? hi[axis] : lo[axis] + (kSide - i) * step; };
    switch (side) {
      case 0:
        return {{along(0), lo[1]}};
      case 1:
        return {{hi[0], along(1)}};
      case 2:
        return {{back(0), hi[1]}};
      default:
        return {{lo[0], back(1)}};
    }
  };
  for (int side = 0; side < 4; ++side) border[side * kSide] = input.AddPoint(at(side, 0), 0);
  for (int side = 0; side < 4; ++side) {
    complex.hints.near = border[side * kSide];
    for (int i = 1; i < kSide; ++i) border[side * kSide + i] = input.AddPoint(at(side, i), 0);
  }
  for (int i = 0; i < 4 * kSide; ++i) input.AddSegment(border[i], border[(i + 1) % (4 * kSide)], 0);
}

// A grid of points on the six sides, the corners first.
template <template <class> class E>
void AddCube(const Complex<3, E>& complex, InputEditor<3, E>& input) {
  const SpaceRules& rules = complex.rules;
  const int cells = rules.grid_cells();
  const double step = rules.grid_spacing();
  const auto at = [&](int axis, int i) {
    return i == cells ? rules.hi()[axis] : rules.lo()[axis] + i * step;
  };
  const auto add = [&](int i, int j, int k) {
    input.AddPoint({{at(0, i), at(1, j), at(2, k)}}, 0);
  };
  for (int m = 0; m < 8; ++m) add(m & 1 ? cells : 0, m & 2 ? cells : 0, m & 4 ? cells : 0);
  for (int i = 0; i <= cells; ++i) {
    for (int j = 0; j <= cells; ++j) {
      for (int k = 0; k <= cells; ++k) {
        const int sides = (i % cells == 0) + (j % cells == 0) + (k % cells == 0);
        if (sides == 1 || sides == 2) add(i, j, k);
      }
    }
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
