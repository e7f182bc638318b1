// A test for many points at once, cheaper than a query for each.
#ifndef DYNMESH_CORE_PLC_FAR_APART_H_
#define DYNMESH_CORE_PLC_FAR_APART_H_

#include <span>

#include "core/base/steps.h"
#include "core/plc/delta.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

// True only if no two of the points are nearer than `limit` (so none are equal). Conservative: may
// return false needlessly: if a decision takes longer than O(n lg n), or if `steps` stop. REQUIRES:
// the points are finite and in `box`, limit > 0. Pure, thread-safe.
template <int D>
bool AreFarApart(std::span<const PointFeature<D>> points, const Box& box, double limit,
                 Steps& steps);

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_FAR_APART_H_
