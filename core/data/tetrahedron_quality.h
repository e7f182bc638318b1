// Is a tetrahedron over a bound? What is flat? Pure, thread-safe.
#ifndef DYNMESH_CORE_DATA_TETRAHEDRON_QUALITY_H_
#define DYNMESH_CORE_DATA_TETRAHEDRON_QUALITY_H_

#include <array>

#include "core/geometry/point.h"
#include "dynmesh/quality.h"

namespace dynmesh::data {

// What MeasureTetrahedron says of a flat one.
TetrahedronQuality FlatTetrahedron();

// Is the ratio of the tetrahedron with these corners, as MeasureTetrahedron has it in `q`,
// more than `bound`? By the exact ratio where q's is too near to tell.
bool IsOverBound(const std::array<geometry::Point3, 4>& corners, const TetrahedronQuality& q,
                 double bound);

}  // namespace dynmesh::data

#endif  // DYNMESH_CORE_DATA_TETRAHEDRON_QUALITY_H_
