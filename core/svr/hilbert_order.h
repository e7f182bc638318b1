// The order in which SVR numbers points of the input.
#ifndef DYNMESH_CORE_SVR_HILBERT_ORDER_H_
#define DYNMESH_CORE_SVR_HILBERT_ORDER_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <vector>

#include "core/geometry/hilbert_curve.h"
#include "core/geometry/point.h"
#include "core/svr/kernel.h"
#include "core/svr/options.h"

namespace dynmesh::svr {

// The indices of `points` in the order of a Hilbert curve over the domain, then of coordinates. So
// neighbours in the list are near each other, and the list is a function of the set.
template <int D>
std::vector<VertexIndex> HilbertOrder(const std::vector<geometry::Point<D>>& points,
                                      const Options<D>& options) {
  constexpr int kLevels = 32 / D;
  const double scale = std::ldexp(1.0, kLevels) / (options.hi[0] - options.lo[0]);
  std::vector<std::tuple<std::uint32_t, geometry::Point<D>, VertexIndex>> keyed;
  keyed.reserve(points.size());
  for (const geometry::Point<D>& p : points) {
    std::array<std::uint32_t, D> cell;
    for (int k = 0; k < D; ++k) {
      const double x =
          std::clamp((p[k] - options.lo[k]) * scale, 0.0, std::ldexp(1.0, kLevels) - 1);
      cell[k] = static_cast<std::uint32_t>(x);
    }
    keyed.emplace_back(geometry::HilbertCurve<D>::Key(cell, kLevels), p,
                       static_cast<VertexIndex>(keyed.size()));
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<VertexIndex> order;
  order.reserve(points.size());
  for (const auto& [key, p, i] : keyed) order.push_back(i);
  return order;
}

}  // namespace dynmesh::svr

#endif  // DYNMESH_CORE_SVR_HILBERT_ORDER_H_
