#include "server/calls/load_pieces.h"

#include <algorithm>
#include <optional>

#include "absl/strings/str_cat.h"
#include "dynmesh/error.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::server {

void LoadPieces::Add(const v1::LoadFeaturesRequest& message, std::size_t first) {
  const auto points = static_cast<std::size_t>(message.points().ids_size());
  if (points != 0 || message.features_size() != 0) pieces_.push_back({messages_, first, points});
  ++messages_;
}

absl::Status LoadPieces::Locate(const absl::Status& status) const {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  if (!detail.has_value() || !detail->edit.has_value()) return status;
  const std::size_t edit = *detail->edit;
  const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), edit,
                                      [](std::size_t e, const Piece& p) { return e < p.first; });
  if (after == pieces_.begin()) return status;
  const Piece& piece = *(after - 1);
  const std::size_t row = edit - piece.first;
  codec::ServiceError error = *codec::GetServiceError(status);
  error.field = row < piece.points ? absl::StrCat("points.ids[", row, "]")
                                   : absl::StrCat("features[", row - piece.points, "]");
  error.metadata["message"] = absl::StrCat(piece.message);
  return codec::MakeServiceError(status.code(), status.message(), error);
}

}  // namespace dynmesh::server
