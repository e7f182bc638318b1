// SVR of points with what it works on.
#ifndef DYNMESH_TESTS_CORE_SVR_SVR_OF_POINTS_H_
#define DYNMESH_TESTS_CORE_SVR_SVR_OF_POINTS_H_

#include <utility>
#include <vector>

#include "tests/core/svr/variants/variants.h"

namespace dynmesh::svr {

template <int D, class Location = VoronoiLocation<D, true>>
struct SvrOfPoints {
  SvrOfPoints(const Options<D>& options, std::vector<geometry::Point<D>> points)
      : input(options, std::move(points)), svr(options, &input, &mesh) {}

  PointInput<D> input;
  Kernel<D> mesh;
  Svr<D, PointInput<D>, Location> svr;
};

// The parameter of typed tests.
template <int D, class L>
struct Case {
  static constexpr int kDimension = D;
  using Location = L;
};

}  // namespace dynmesh::svr

#endif  // DYNMESH_TESTS_CORE_SVR_SVR_OF_POINTS_H_
