#include "server/journal/postgres_leases.h"

#include <algorithm>
#include <chrono>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "server/base/boot_time.h"
#include "server/journal/journal_errors.h"
#include "server/journal/row_sum.h"

namespace dynmesh::server::postgres {
namespace {

constexpr int kMostClaims = 20;

// Which additions are missing: the first table and the column, the index, the second table.
constexpr char kMissing[] =
    "SELECT to_regclass('dynmesh.nodes') IS NULL, to_regclass('dynmesh.meshes_by_owner') IS NULL, "
    "to_regclass('dynmesh.followers') IS NULL "
    "FROM pg_advisory_xact_lock(28273260616281960)";
// A default that is constant: no row is rewritten.
constexpr char kLeaseTables[] = R"(
  CREATE TABLE dynmesh.nodes(
    id TEXT COLLATE "C" PRIMARY KEY, address TEXT NOT NULL, seen TIMESTAMPTZ NOT NULL);
  ALTER TABLE dynmesh.meshes ADD COLUMN lease_until TIMESTAMPTZ NOT NULL DEFAULT '-infinity';
)";
// Without it each renewal reads the rows of all meshes. It does not change with a renewal.
constexpr char kIndex[] = "CREATE INDEX meshes_by_owner ON dynmesh.meshes(owner)";

constexpr char kFollowers[] = R"(
  CREATE TABLE dynmesh.followers(
    mesh BIGINT NOT NULL, node TEXT COLLATE "C" NOT NULL, asked BOOLEAN NOT NULL,
    is_warm BOOLEAN NOT NULL, PRIMARY KEY(mesh, node));
  CREATE INDEX followers_by_node ON dynmesh.followers(node))";

constexpr char kRenew[] = R"(
WITH me AS (
  INSERT INTO dynmesh.nodes(id, address, seen) VALUES($1::text, $2::text, clock_timestamp())
  ON CONFLICT(id) DO UPDATE SET address = excluded.address, seen = clock_timestamp()),
dead AS (
  DELETE FROM dynmesh.nodes WHERE id IN (
    SELECT id FROM dynmesh.nodes WHERE seen < clock_timestamp() - interval '1 day'
      AND id <> $1::text FOR UPDATE SKIP LOCKED) RETURNING id),
forgotten AS (DELETE FROM dynmesh.followers WHERE node IN (SELECT id FROM dead)),
mine AS (
  UPDATE dynmesh.meshes SET lease_until = clock_timestamp() + $3::bigint * interval '1 microsecond'
  WHERE owner = $1::text AND lease_until > '-infinity' RETURNING key)
SELECT key FROM mine ORDER BY key)";
constexpr char kLive[] = R"(
SELECT convert_to(id, 'UTF8'), convert_to(address, 'UTF8') FROM dynmesh.nodes
WHERE seen > clock_timestamp() - $1::bigint * interval '1 microsecond' ORDER BY id)";
// If a concurrent claim changed the row, the condition is evaluated again on what it left. If the
// row was only locked, the end of the lease is that of before the wait for the lock: see ClaimFree.
constexpr char kClaimFree[] = R"(
UPDATE dynmesh.meshes SET epoch = epoch + 1, owner = $2::text,
  lease_until = clock_timestamp() + $3::bigint * interval '1 microsecond'
WHERE key = $1::bigint AND (owner = $2::text OR lease_until <= clock_timestamp())
RETURNING epoch, head, answers)";
constexpr char kHolder[] = R"(
SELECT convert_to(m.owner, 'UTF8'), convert_to(coalesce(n.address, ''), 'UTF8'), m.epoch,
  CASE WHEN m.lease_until = '-infinity' THEN 0
    ELSE (extract(epoch FROM m.lease_until - clock_timestamp()) * 1000000)::bigint END
FROM dynmesh.meshes AS m LEFT JOIN dynmesh.nodes AS n ON n.id = m.owner WHERE m.key = $1::bigint)";
// The columns of a Located. Parameter 1: the node that asks. `followers`: the last column.
#define DYNMESH_PLACES(followers)                                                   \
  "SELECT m.key, convert_to(m.id, 'UTF8'), m.description, m.checksum, m.head, "     \
  "head - snapshot + (snapshot > 0)::integer, (m.owner = $1::text)::integer, "      \
  "convert_to(coalesce(n.address, ''), 'UTF8'), m.epoch, "                          \
  "CASE WHEN m.lease_until = '-infinity' THEN 0 "                                   \
  "ELSE (extract(epoch FROM m.lease_until - clock_timestamp()) * 1000000)::bigint " \
  "END, " followers "FROM dynmesh.meshes AS m LEFT JOIN dynmesh.nodes AS n ON n.id = m.owner "
constexpr char kLocate[] = DYNMESH_PLACES(
    "(SELECT convert_to(coalesce(string_agg(w.address, ' ' ORDER BY w.address), ''), "
    "'UTF8') "
    "FROM dynmesh.followers AS f JOIN dynmesh.nodes AS w ON w.id = f.node WHERE f.mesh = "
    "m.key "
    "AND f.is_warm AND w.seen > clock_timestamp() - $3::bigint * interval '1 "
    "microsecond') ") "WHERE m.id = $2::text";
constexpr char kLocateAll[] =
    DYNMESH_PLACES("''::bytea ") "WHERE m.id > $2::text ORDER BY m.id LIMIT $3::bigint";
#undef DYNMESH_PLACES
// True. What is said of followers is a hint, which is said again when it is lost: such a commit
// waits for no disk and no standby. The setting ends with the transaction.
#define DYNMESH_QUICK "(SELECT set_config('synchronous_commit', 'off', true)) = 'off'"
// Parameters: 1 and 2 mesh and address of each wish, 3 all meshes, 4 ttl. No address has a comma.
// Without a change no row is locked, and nothing is written.
constexpr char kAsk[] =
    "WITH wish AS ("
    "  SELECT w.mesh, n.id AS node"
    "  FROM unnest($1::bigint[], string_to_array($2::text, ',')) AS w(mesh, address)"
    "  JOIN dynmesh.nodes AS n ON n.address = w.address"
    "    AND n.seen > clock_timestamp() - $4::bigint * interval '1 microsecond'), "
    "others AS ("
    "  UPDATE dynmesh.followers AS f SET asked = false WHERE f.mesh = ANY($3::bigint[]) AND f.asked"
    "  AND NOT EXISTS(SELECT 1 FROM wish WHERE wish.mesh = f.mesh AND wish.node = f.node)"
    "  AND " DYNMESH_QUICK
    ") INSERT INTO dynmesh.followers AS f(mesh, node, asked, is_warm) "
    "SELECT mesh, node, true, false FROM wish "
    "WHERE NOT EXISTS(SELECT 1 FROM dynmesh.followers AS a"
    "  WHERE a.mesh = wish.mesh AND a.node = wish.node AND a.asked) AND " DYNMESH_QUICK
    " ON CONFLICT (mesh, node) DO UPDATE SET asked = true";
constexpr char kAsked[] =
    "WITH gone AS ("
    "  DELETE FROM dynmesh.followers AS f WHERE f.node = $1::text"
    "  AND NOT EXISTS(SELECT 1 FROM dynmesh.meshes AS m WHERE m.key = f.mesh) AND " DYNMESH_QUICK
    ") SELECT convert_to(m.id, 'UTF8') FROM dynmesh.followers AS f JOIN dynmesh.meshes AS m "
    "ON m.key = f.mesh WHERE f.node = $1::text AND f.asked AND m.owner <> $1::text ORDER BY m.id";
constexpr char kFollow[] =
    "INSERT INTO dynmesh.followers(mesh, node, asked, is_warm) "
    "SELECT $1::bigint, $2::text, false, true WHERE " DYNMESH_QUICK
    " ON CONFLICT (mesh, node) DO UPDATE SET is_warm = true";
constexpr char kUnfollow[] =
    "DELETE FROM dynmesh.followers WHERE mesh = $1::bigint AND node = $2::text AND " DYNMESH_QUICK;
#undef DYNMESH_QUICK
// Of two nodes with an address the one that renewed last: the other one was there before.
constexpr char kHandOver[] = R"(
UPDATE dynmesh.meshes AS m SET epoch = epoch + 1, owner = n.id,
  lease_until = clock_timestamp() + $5::bigint * interval '1 microsecond'
FROM (SELECT id FROM dynmesh.nodes WHERE address = $4::text
    AND seen > clock_timestamp() - $5::bigint * interval '1 microsecond'
  ORDER BY seen DESC LIMIT 1) AS n
WHERE m.key = $1::bigint AND m.owner = $2::text AND m.epoch = $3::bigint
RETURNING m.epoch)";
constexpr char kGiveUp[] = R"(
WITH gone AS (DELETE FROM dynmesh.nodes WHERE id = $1::text),
unfollowed AS (DELETE FROM dynmesh.followers WHERE node = $1::text)
UPDATE dynmesh.meshes SET lease_until = '-infinity' WHERE owner = $1::text)";

SharedJournal::Located LocatedOf(const Answer& answer, std::size_t row) {
  SharedJournal::Located located;
  Journal::Mesh& mesh = located.mesh;
  mesh.key = answer.Integer(row, 0);
  mesh.id = answer.Bytes(row, 1);
  mesh.description = answer.Bytes(row, 2);
  mesh.entries = static_cast<std::uint64_t>(answer.Integer(row, 5));
  if (RowSumOf(absl::string_view(mesh.id), absl::string_view(mesh.description)) !=
      answer.Integer(row, 3)) {
    mesh.damage = ReadingErrors(mesh.id).Damaged("the description");
  }
  located.revision = static_cast<std::uint64_t>(answer.Integer(row, 4));
  located.is_mine = answer.Integer(row, 6) != 0;
  located.address = answer.Bytes(row, 7);
  located.epoch = answer.Integer(row, 8);
  located.left = absl::Microseconds(answer.Integer(row, 9));
  located.followers = absl::StrSplit(answer.Bytes(row, 10), ' ', absl::SkipEmpty());
  return located;
}

absl::Status Add(Session& session) {
  if (absl::Status s = session.Execute("BEGIN").status; !s.ok()) return s;
  const Answer missing = session.Execute(kMissing);
  if (!missing.status.ok()) return missing.status;
  if (missing.rows[0][0].as<bool>()) {
    if (absl::Status s = session.Execute(kLeaseTables).status; !s.ok()) return s;
  }
  if (missing.rows[0][1].as<bool>()) {
    if (absl::Status s = session.Execute(kIndex).status; !s.ok()) return s;
  }
  if (missing.rows[0][2].as<bool>()) {
    if (absl::Status s = session.Execute(kFollowers).status; !s.ok()) return s;
  }
  return session.Execute("COMMIT").status;
}

}  // namespace

absl::Status PrepareLeases(Session& session) {
  absl::Status added = Add(session);
  if (!added.ok()) session.Spoil();  // the transaction ends with the connection
  return added;
}

absl::StatusOr<std::vector<std::int64_t>> RenewLeases(Session& session, const Node& node,
                                                      absl::Duration ttl) {
  const Answer answer =
      session.Run(kRenew, node.id, node.address, std::int64_t{absl::ToInt64Microseconds(ttl)});
  if (!answer.status.ok()) return answer.status;
  std::vector<std::int64_t> meshes;
  for (std::size_t i = 0; i < answer.size(); ++i) meshes.push_back(answer.Integer(i, 0));
  return meshes;
}

absl::StatusOr<std::vector<Node>> LiveNodes(Session& session, absl::Duration ttl) {
  const Answer answer = session.Run(kLive, std::int64_t{absl::ToInt64Microseconds(ttl)});
  if (!answer.status.ok()) return answer.status;
  std::vector<Node> nodes;
  for (std::size_t i = 0; i < answer.size(); ++i) {
    nodes.push_back({answer.Bytes(i, 0), answer.Bytes(i, 1)});
  }
  return nodes;
}

FreeClaim ClaimFree(Session& session, std::int64_t mesh, const std::string& node,
                    absl::Duration ttl) {
  FreeClaim claim;
  for (int attempt = 1;; ++attempt) {
    const std::chrono::nanoseconds sent = BootTime();
    const Answer taken =
        session.Run(kClaimFree, mesh, node, std::int64_t{absl::ToInt64Microseconds(ttl)});
    claim.status = taken.status;
    claim.unknown = taken.unknown;
    if (!taken.status.ok()) return claim;
    if (taken.empty()) break;
    if (BootTime() - sent <= absl::ToChronoNanoseconds(ttl / 10)) {
      claim.belief = {taken.Integer(0, 0), taken.Integer(0, 1), taken.Integer(0, 2)};
      return claim;
    }
    if (attempt == kMostClaims) {
      claim.status = absl::UnavailableError("the database takes too long to grant a lease");
      return claim;
    }
  }
  const Answer holder = session.Run(kHolder, mesh);
  claim.status = holder.status;
  if (!holder.status.ok()) return claim;
  if (holder.empty()) {
    claim.status = NoSuchMesh();
    return claim;
  }
  claim.held = true;
  // The lease may have ended between the statements: the next claim is granted then.
  claim.holder = {{holder.Bytes(0, 0), holder.Bytes(0, 1)},
                  holder.Integer(0, 2),
                  absl::Microseconds(std::max<std::int64_t>(holder.Integer(0, 3), 1))};
  return claim;
}

absl::StatusOr<SharedJournal::Located> LocateMesh(Session& session, const std::string& id,
                                                  const std::string& node, absl::Duration ttl) {
  const Answer answer =
      session.Run(kLocate, node, id, std::int64_t{absl::ToInt64Microseconds(ttl)});
  if (!answer.status.ok()) return answer.status;
  if (answer.empty()) return NoSuchMesh();
  return LocatedOf(answer, 0);
}

absl::StatusOr<std::vector<SharedJournal::Located>> LocateMeshes(Session& session,
                                                                 const std::string& after,
                                                                 std::size_t limit,
                                                                 const std::string& node) {
  const Answer answer =
      session.Run(kLocateAll, node, after, std::int64_t{static_cast<std::int64_t>(limit)});
  if (!answer.status.ok()) return answer.status;
  std::vector<SharedJournal::Located> all;
  for (std::size_t row = 0; row < answer.size(); ++row) all.push_back(LocatedOf(answer, row));
  return all;
}

absl::Status AskToFollow(Session& session, const std::vector<SharedJournal::Wish>& wishes,
                         absl::Duration ttl) {
  std::vector<std::int64_t> all, wished;
  std::vector<absl::string_view> addresses;
  for (const SharedJournal::Wish& wish : wishes) {
    all.push_back(wish.mesh);
    for (const std::string& address : wish.addresses) {
      wished.push_back(wish.mesh);
      addresses.push_back(address);
    }
  }
  return session
      .Run(kAsk, wished, absl::StrJoin(addresses, ","), all,
           std::int64_t{absl::ToInt64Microseconds(ttl)})
      .status;
}

absl::StatusOr<std::vector<std::string>> AskedToFollow(Session& session, const std::string& node) {
  const Answer asked = session.Run(kAsked, node);
  if (!asked.status.ok()) return asked.status;
  std::vector<std::string> meshes;
  for (std::size_t row = 0; row < asked.size(); ++row) meshes.push_back(asked.Bytes(row, 0));
  return meshes;
}

absl::Status SetFollows(Session& session, std::int64_t mesh, const std::string& node,
                        bool follows) {
  return session.Run(follows ? kFollow : kUnfollow, mesh, node).status;
}

absl::StatusOr<std::int64_t> HandOver(Session& session, std::int64_t mesh, const Hold& hold,
                                      const std::string& address, absl::Duration ttl) {
  const Answer given = session.Run(kHandOver, mesh, hold.node, hold.epoch, address,
                                   std::int64_t{absl::ToInt64Microseconds(ttl)});
  if (!given.status.ok()) return given.status;
  if (!given.empty()) return given.Integer(0, 0);
  return absl::FailedPreconditionError(absl::StrCat(
      "no server at ", address, " renews leases, or the mesh is not this server's any more"));
}

absl::Status GiveUpLeases(Session& session, const std::string& node) {
  return session.Run(kGiveUp, node).status;
}

}  // namespace dynmesh::server::postgres
