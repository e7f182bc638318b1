#include "core/quadtree/build_qt_procedures.h"

namespace dynmesh::quadtree {

template class BuildQt<2, sac::Engine>;
template class BuildQt<2, sac::UntracedEngine>;
template class BuildQt<3, sac::Engine>;
template class BuildQt<3, sac::UntracedEngine>;

}  // namespace dynmesh::quadtree
