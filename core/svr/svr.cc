#include "core/svr/svr_procedures.h"

namespace dynmesh::svr {

template class Svr<2, PlcInput<2>>;
template class Svr<3, PlcInput<3>>;

}  // namespace dynmesh::svr
