#include "tests/core/svr/variants/variants.h"

#include "core/svr/svr_procedures.h"

namespace dynmesh::svr {

template class Svr<2, PointInput<2>>;
template class Svr<2, PointInput<2>, VoronoiLocation<2, false>>;
template class Svr<2, PointInput<2>, SimplexLocation<2>>;
template class Svr<2, PointInput<2>, BallLocation<2>>;
template class Svr<3, PointInput<3>>;
template class Svr<3, PointInput<3>, VoronoiLocation<3, false>>;
template class Svr<3, PointInput<3>, SimplexLocation<3>>;
template class Svr<3, PointInput<3>, BallLocation<3>>;
template class Svr<4, PointInput<4>>;
template class Svr<4, PointInput<4>, SimplexLocation<4>>;
template class Svr<4, PointInput<4>, BallLocation<4>>;

}  // namespace dynmesh::svr
