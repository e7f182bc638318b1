// What the point location structures of SVR count.
#ifndef DYNMESH_CORE_SVR_LOCATION_COUNTS_H_
#define DYNMESH_CORE_SVR_LOCATION_COUNTS_H_

#include <cstdint>

namespace dynmesh::svr {

struct LocationCounts {
  std::uint64_t queries = 0;     // for a point in a ball
  std::uint64_t looked_at = 0;   // points, in queries and updates
  std::uint64_t reassigned = 0;  // points put into another list, once for each list
  std::uint64_t predicates = 0;  // exact tests of a point in updates
};

}  // namespace dynmesh::svr

#endif  // DYNMESH_CORE_SVR_LOCATION_COUNTS_H_
