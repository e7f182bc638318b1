#include "core/meshing/sizing_field.h"

#include <algorithm>

namespace dynmesh::meshing {

template <int D>
bool SizingRegion<D>::Meets(const geometry::Point<D>& centre, double ball_radius) const {
  double d2 = 0;
  for (int i = 0; i < D; ++i) {
    const double d = std::max({lo[i] - centre[i], centre[i] - hi[i], 0.0});
    d2 += d * d;
  }
  const double reach = ball_radius + radius;
  if (d2 > reach * reach) return false;
  if constexpr (D == 2) return area == nullptr || area->Meets(centre, ball_radius);
  return true;
}

template struct SizingRegion<2>;
template struct SizingRegion<3>;

}  // namespace dynmesh::meshing
