// In place of the journal in PostgreSQL in a build without libpqxx.
#include "server/journal/open_postgres.h"

namespace dynmesh::server {

absl::StatusOr<std::unique_ptr<Journal>> OpenPostgresJournal(const std::string&,
                                                             const PostgresOptions&) {
  return absl::FailedPreconditionError(
      "this dynmeshd was built without PostgreSQL: build it where libpqxx-dev is installed, or use "
      "--data-dir");
}

}  // namespace dynmesh::server
