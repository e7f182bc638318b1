#include "server/journal/schemas.h"

#include <cstddef>

#include "absl/strings/str_cat.h"

namespace dynmesh::server {

absl::Status CheckSchema(std::int64_t schema, const Schemas& schemas) {
  if (schema > schemas.present()) {
    return absl::FailedPreconditionError(absl::StrCat("it has schema ", schema,
                                                      ", this dynmeshd knows ", schemas.present(),
                                                      ": take the newer version that wrote it"));
  }
  if (schema != 0 && schema < schemas.first) {
    return absl::FailedPreconditionError(absl::StrCat(
        "it has schema ", schema, ", the oldest that this dynmeshd reads is ", schemas.first,
        ": start the version that wrote it, save each mesh's features (dynmesh features), and load "
        "them into a new ",
        schemas.store));
  }
  return absl::OkStatus();
}

std::string StepsFrom(std::int64_t schema, const Schemas& schemas) {
  std::string sql = schema == 0 ? schemas.tables : "";
  const std::size_t done = schema == 0 ? 0 : static_cast<std::size_t>(schema - schemas.first);
  for (const char* step : schemas.steps.subspan(done)) sql += step;
  return sql;
}

}  // namespace dynmesh::server
