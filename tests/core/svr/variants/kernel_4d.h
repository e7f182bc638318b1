// What SVR sees of a Delaunay kernel in 4D (core/svr/kernel.h).
#ifndef DYNMESH_TESTS_CORE_SVR_VARIANTS_KERNEL_4D_H_
#define DYNMESH_TESTS_CORE_SVR_VARIANTS_KERNEL_4D_H_

#include "core/svr/kernel.h"
#include "tests/core/svr/variants/bowyer_watson.h"

namespace dynmesh::svr {

template <>
struct KernelOf<4> {
  using Type = delaunay::BowyerWatson<4>;
};

}  // namespace dynmesh::svr

namespace dynmesh::delaunay {

// Here, since SVR finds it by its argument.
inline svr::Ball<4> BallOf(const BowyerWatson<4>& mesh, svr::SimplexIndex s) {
  const auto ball = mesh.BallOf(s);
  return {ball.centre, ball.r2};
}

}  // namespace dynmesh::delaunay

#endif  // DYNMESH_TESTS_CORE_SVR_VARIANTS_KERNEL_4D_H_
