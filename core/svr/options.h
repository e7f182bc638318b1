// The numbers of a run of SVR.
#ifndef DYNMESH_CORE_SVR_OPTIONS_H_
#define DYNMESH_CORE_SVR_OPTIONS_H_

#include "core/geometry/point.h"

namespace dynmesh::svr {

template <int D>
struct Options {
  // The domain: a square, cube, ... It should be 4 times as large as the points' extent, or larger:
  // simplices with a circumcenter outside are not split.
  geometry::Point<D> lo{}, hi{};
  int border_cells = 0;  // of the grid on each side of the domain
  double quality = 2;    // rho
  double k = 0.9;        // how far uninserted points attract a circumcenter
  // Asks a tree first whether an uninserted point may be near (waiting_tree.h). Changes no result.
  bool asks_tree_first = true;
};

}  // namespace dynmesh::svr

#endif  // DYNMESH_CORE_SVR_OPTIONS_H_
