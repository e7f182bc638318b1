// Whether the core takes cleaned input.
#ifndef DYNMESH_TESTS_CLIENT_CLEANING_IS_LEGAL_H_
#define DYNMESH_TESTS_CLIENT_CLEANING_IS_LEGAL_H_

#include "absl/status/status.h"
#include "dynmesh/error.h"

namespace dynmesh::cleaning {

// OK, or more vertices than a mesh may have, where the tolerance is near the last bits of
// coordinates: what is a few tolerances apart stays apart, and is legal in itself.
inline bool IsLegal(const absl::Status& status, double tolerance) {
  constexpr double kLastBits = 1e-10;
  const auto detail = GetErrorDetail(status);
  const bool is_limit = detail.has_value() && detail->reason == reason::kVertexLimit;
  return status.ok() || (is_limit && tolerance < kLastBits);
}

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_TESTS_CLIENT_CLEANING_IS_LEGAL_H_
