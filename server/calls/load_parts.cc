#include "server/calls/load_parts.h"

#include <algorithm>
#include <optional>

#include "absl/strings/str_cat.h"
#include "dynmesh/error.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::server {

void LoadParts::Add(std::size_t first, std::size_t points, std::size_t features) {
  if (points != 0 || features != 0) parts_.push_back({messages_, first, points});
  ++messages_;
}

absl::Status LoadParts::Locate(const absl::Status& status) const {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  if (!detail.has_value() || !detail->edit.has_value()) return status;
  const std::size_t edit = *detail->edit;
  const auto after = std::upper_bound(parts_.begin(), parts_.end(), edit,
                                      [](std::size_t e, const Part& p) { return e < p.first; });
  if (after == parts_.begin()) return status;
  const Part& part = *(after - 1);
  const std::size_t row = edit - part.first;
  codec::ServiceError error = *codec::GetServiceError(status);
  error.field = row < part.points ? absl::StrCat("points.ids[", row, "]")
                                  : absl::StrCat("features[", row - part.points, "]");
  error.metadata["message"] = absl::StrCat(part.message);
  return codec::MakeServiceError(status.code(), status.message(), error);
}

}  // namespace dynmesh::server
