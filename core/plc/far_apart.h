// A certificate for many points at once, cheaper than a query of each.
#ifndef DYNMESH_CORE_PLC_FAR_APART_H_
#define DYNMESH_CORE_PLC_FAR_APART_H_

#include <span>

#include "core/base/steps.h"
#include "core/plc/delta.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

// True only if no two of the points are nearer than `limit`, so none are equal. False
// says nothing: it is also the answer where finding out would take longer than O(n lg n), or
// where `steps` are stopped.
// REQUIRES: the points are finite and in `box`, limit > 0. Pure, thread-safe.
template <int D>
bool AreFarApart(std::span<const PointFeature<D>> points, const Box& box, double limit,
                 Steps& steps);

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_FAR_APART_H_
