// Conversion from radians to degrees. Pure.
#ifndef DYNMESH_CORE_QUALITY_DEGREES_H_
#define DYNMESH_CORE_QUALITY_DEGREES_H_

#include <numbers>

namespace dynmesh::quality {

inline double Degrees(double radians) { return radians * (180 / std::numbers::pi); }

}  // namespace dynmesh::quality

#endif  // DYNMESH_CORE_QUALITY_DEGREES_H_
