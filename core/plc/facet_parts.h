// Is the inside of a facet connected? Rings may lie side by side, in each other's holes, or
// cross in common corners. Pure, thread-safe.
#ifndef DYNMESH_CORE_PLC_FACET_PARTS_H_
#define DYNMESH_CORE_PLC_FACET_PARTS_H_

#include "core/plc/facet.h"

namespace dynmesh::plc {

// Is the inside disconnected? Parts that touch in corners only are not connected. REQUIRES: a valid
// facet: its edges meet in corners only, at angles that are not small. O(1) for one ring, else O(k
// lg^2 k) for k corners.
bool FallsApart(const Facet& facet);

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_FACET_PARTS_H_
