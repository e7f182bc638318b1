// SVR as the experiments compare it: of points alone, with other point locations, and in 4D. The
// product has none of it.
#ifndef DYNMESH_TESTS_CORE_SVR_VARIANTS_VARIANTS_H_
#define DYNMESH_TESTS_CORE_SVR_VARIANTS_VARIANTS_H_

#include "core/svr/svr.h"
#include "tests/core/svr/variants/ball_location.h"
#include "tests/core/svr/variants/kernel_4d.h"
#include "tests/core/svr/variants/point_input.h"
#include "tests/core/svr/variants/simplex_location.h"

namespace dynmesh::svr {

extern template class Svr<2, PointInput<2>>;
extern template class Svr<2, PointInput<2>, VoronoiLocation<2, false>>;
extern template class Svr<2, PointInput<2>, SimplexLocation<2>>;
extern template class Svr<2, PointInput<2>, BallLocation<2>>;
extern template class Svr<3, PointInput<3>>;
extern template class Svr<3, PointInput<3>, VoronoiLocation<3, false>>;
extern template class Svr<3, PointInput<3>, SimplexLocation<3>>;
extern template class Svr<3, PointInput<3>, BallLocation<3>>;
extern template class Svr<4, PointInput<4>>;
extern template class Svr<4, PointInput<4>, SimplexLocation<4>>;
extern template class Svr<4, PointInput<4>, BallLocation<4>>;

}  // namespace dynmesh::svr

#endif  // DYNMESH_TESTS_CORE_SVR_VARIANTS_VARIANTS_H_
