#include "core/io/common/locate.h"

#include <optional>

#include "core/base/text.h"
#include "dynmesh/error.h"

namespace dynmesh::io {

absl::Status Locate(const absl::Status& status, const WhereFeature& where) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  return detail ? LocateFeatures(status, detail->features, where) : status;
}

absl::Status LocateFeatures(const absl::Status& status, const std::vector<FeatureId>& features,
                            const WhereFeature& where) {
  if (status.ok()) return status;
  std::string before;
  std::string after;
  for (const FeatureId id : features) {
    const std::string place = where(id);
    if (place.empty()) continue;
    if (before.empty()) {
      before = place + ": ";
    } else {
      after += text::Concat(after.empty() ? " (" : ", ", id, " at ", place);
    }
  }
  if (!after.empty()) after += ")";
  return absl::Status(status.code(), text::Concat(before, text::View(status.message()), after));
}

}  // namespace dynmesh::io
