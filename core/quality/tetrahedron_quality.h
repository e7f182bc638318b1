// Exact tests of tetrahedra: ratio over a bound, flatness. Pure, thread-safe.
#ifndef DYNMESH_CORE_QUALITY_TETRAHEDRON_QUALITY_H_
#define DYNMESH_CORE_QUALITY_TETRAHEDRON_QUALITY_H_

#include <array>

#include "core/geometry/point.h"
#include "dynmesh/quality.h"

namespace dynmesh::quality {

// The result of MeasureTetrahedron for a flat tetrahedron.
TetrahedronQuality FlatTetrahedron();

// Is the ratio of the tetrahedron with these corners greater than `bound`? `q` is its
// MeasureTetrahedron. Computes the exact ratio if that of q is too close to decide.
bool IsOverBound(const std::array<geometry::Point3, 4>& corners, const TetrahedronQuality& q,
                 double bound);

}  // namespace dynmesh::quality

#endif  // DYNMESH_CORE_QUALITY_TETRAHEDRON_QUALITY_H_
