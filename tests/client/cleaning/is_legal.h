// Whether the core accepts cleaned input.
#ifndef DYNMESH_TESTS_CLIENT_CLEANING_IS_LEGAL_H_
#define DYNMESH_TESTS_CLIENT_CLEANING_IS_LEGAL_H_

#include "absl/status/status.h"
#include "dynmesh/error.h"

namespace dynmesh::cleaning {

// OK, or more vertices than a mesh may have. The latter occurs if the tolerance is near an ulp of
// the coordinates: points a few tolerances apart stay apart, and are legal in themselves.
inline bool IsLegal(const absl::Status& status, double tolerance) {
  constexpr double kLastBits = 1e-10;
  const auto detail = GetErrorDetail(status);
  const bool is_limit = detail.has_value() && detail->reason == reason::kVertexLimit;
  return status.ok() || (is_limit && tolerance < kLastBits);
}

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_TESTS_CLIENT_CLEANING_IS_LEGAL_H_
