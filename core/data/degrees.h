// Conversion from radians to degrees. Pure.
#ifndef DYNMESH_CORE_DATA_DEGREES_H_
#define DYNMESH_CORE_DATA_DEGREES_H_

#include <numbers>

namespace dynmesh::data {

inline double Degrees(double radians) { return radians * (180 / std::numbers::pi); }

}  // namespace dynmesh::data

#endif  // DYNMESH_CORE_DATA_DEGREES_H_
