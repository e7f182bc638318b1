#include "server/journal/postgres_use.h"

#include <chrono>
#include <thread>

#include "absl/strings/str_cat.h"

namespace dynmesh::server::postgres {
namespace {

constexpr char kExistingTables[] =
    "SELECT (to_regclass('dynmesh.journal') IS NOT NULL)::integer, "
    "(to_regclass('dynmesh.nodes') IS NOT NULL)::integer";
constexpr char kOthers[] =
    "SELECT count(*) FROM pg_stat_activity WHERE datname = current_database() AND "
    "application_name = 'dynmeshd' AND pid <> pg_backend_pid()";
constexpr char kLeased[] = R"(
SELECT count(*), coalesce(ceil(extract(epoch FROM max(lease_until) - clock_timestamp())), 0)::bigint,
  convert_to(coalesce(string_agg(DISTINCT n.address, ' '), ''), 'UTF8')
FROM dynmesh.meshes AS m LEFT JOIN dynmesh.nodes AS n ON n.id = m.owner
WHERE lease_until > clock_timestamp())";

absl::Status DatabaseInUse(const absl::AlphaNum& how) {
  return absl::FailedPreconditionError(
      absl::StrCat("a server uses it: ", how.Piece(), ". End the server with SIGTERM"));
}

// The database notices a moment later that a server has ended.
absl::Status CheckConnections(Session& session) {
  constexpr int kAttempts = 20;
  std::int64_t count = 0;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (attempt > 0) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const Answer others = session.Execute(kOthers);
    if (!others.status.ok()) return others.status;
    count = others.Integer(0, 0);
    if (count == 0) return absl::OkStatus();
  }
  return DatabaseInUse(absl::StrCat("there are ", count, " connections of dynmeshd"));
}

}  // namespace

absl::Status CheckUse(Session& session, const PostgresOptions& options) {
  if (options.make_tables && !options.exclusive) return absl::OkStatus();
  const Answer tables = session.Execute(kExistingTables);
  if (!tables.status.ok()) return tables.status;
  if (!options.make_tables && tables.Integer(0, 0) == 0) {
    return absl::NotFoundError("it has no journal of dynmeshd");
  }
  if (!options.exclusive) return absl::OkStatus();
  if (absl::Status s = CheckConnections(session); !s.ok()) return s;
  if (tables.Integer(0, 1) == 0) return absl::OkStatus();
  const Answer leased = session.Execute(kLeased);
  if (!leased.status.ok()) return leased.status;
  if (leased.Integer(0, 0) == 0) return absl::OkStatus();
  return DatabaseInUse(absl::StrCat("the lease of ", leased.Integer(0, 0), " meshes runs for ",
                                    leased.Integer(0, 1), " s (", leased.Bytes(0, 2), ")"));
}

}  // namespace dynmesh::server::postgres
