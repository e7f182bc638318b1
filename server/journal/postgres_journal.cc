#include "server/journal/postgres_journal.h"

#include <algorithm>
#include <chrono>
#include <random>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "server/base/boot_time.h"
#include "server/base/log.h"
#include "server/journal/journal_errors.h"
#include "server/journal/postgres_generations.h"
#include "server/journal/postgres_leases.h"
#include "server/journal/postgres_reading.h"
#include "server/journal/postgres_schema.h"
#include "server/journal/postgres_use.h"
#include "server/journal/row_sum.h"

namespace dynmesh::server {
namespace {

using postgres::Answer;
using postgres::Session;

constexpr char kNextKey[] =
    "SELECT nextval(pg_get_serial_sequence('dynmesh.meshes', 'key')::regclass)";
constexpr char kCreate[] = R"(
WITH made AS (
  INSERT INTO dynmesh.meshes(key, id, description, checksum, owner)
  VALUES($1::bigint, $2::text, $3::bytea, $4::bigint, $5::text)
  ON CONFLICT DO NOTHING RETURNING key),
first AS (
  INSERT INTO dynmesh.generations(mesh, revision, parts, bytes) SELECT key, 0, 0, 0 FROM made)
SELECT key FROM made)";
// Its tables have the additions of postgres_leases.h. Parameter 6: the lease in microseconds.
constexpr char kCreateLeased[] = R"(
WITH made AS (
  INSERT INTO dynmesh.meshes(key, id, description, checksum, owner, lease_until)
  VALUES($1::bigint, $2::text, $3::bytea, $4::bigint, $5::text,
    clock_timestamp() + $6::bigint * interval '1 microsecond')
  ON CONFLICT DO NOTHING RETURNING key),
first AS (
  INSERT INTO dynmesh.generations(mesh, revision, parts, bytes) SELECT key, 0, 0, 0 FROM made)
SELECT key FROM made)";
constexpr char kDelete[] = R"(
WITH gone AS (DELETE FROM dynmesh.meshes WHERE key = $1::bigint RETURNING key),
g AS (DELETE FROM dynmesh.generations WHERE mesh IN (SELECT key FROM gone)),
r AS (DELETE FROM dynmesh.requests WHERE mesh IN (SELECT key FROM gone))
SELECT key FROM gone)";

std::string FreshOwner() {
  std::random_device random;
  const auto word = [&random] { return (std::uint64_t{random()} << 32) | random(); };
  return absl::StrCat(absl::Hex(word(), absl::kZeroPad16), absl::Hex(word(), absl::kZeroPad16));
}

// In a database where the settings allow less than this class promises.
void WarnOfUnsafeSettings(Session& session, const std::string& name) {
  const Answer unsafe = session.Execute(
      "SELECT convert_to(string_agg(name || '=' || setting, ' '), 'UTF8') FROM pg_settings WHERE "
      "name IN ('fsync', 'full_page_writes') AND setting = 'off'");
  if (!unsafe.status.ok() || unsafe.IsNull(0, 0)) return;
  Log(LogLevel::kWarning, "journal_unsafe",
      {{"journal", name},
       {"settings", unsafe.Bytes(0, 0)},
       {"message", "the database may lose acknowledged edits when the power fails"}});
}

// With leases another server can have the mesh of one that stopped after about this time.
absl::Duration BetweenStatements(const PostgresOptions& options) {
  if (options.lease == absl::ZeroDuration()) return absl::Minutes(1);
  return std::max(options.lease, absl::Milliseconds(500));
}

// A database that is busy, or restarts, may lose a connection that it has made.
constexpr absl::Duration kTriesOfAStart = absl::Seconds(1), kBetweenTries = absl::Milliseconds(300);

}  // namespace

absl::StatusOr<std::unique_ptr<Journal>> OpenPostgresJournal(const std::string& url,
                                                             const PostgresOptions& options) {
  return PostgresJournal::Open(url, options);
}

absl::StatusOr<std::unique_ptr<PostgresJournal>> PostgresJournal::Open(const std::string& url,
                                                                       const Options& options) {
  const absl::StatusOr<postgres::Target> target = postgres::ParseTarget(url, options.lease);
  if (!target.ok()) return target.status();
  std::unique_ptr<PostgresJournal> journal(new PostgresJournal(*target, options));
  const auto named = [&target](const absl::Status& status) {
    return absl::Status(status.code(), absl::StrCat(target->name, ": ", status.message()));
  };
  absl::StatusOr<std::vector<std::int64_t>> deleted;
  for (const absl::Time end = absl::Now() + kTriesOfAStart;; absl::SleepFor(kBetweenTries)) {
    absl::StatusOr<postgres::Pool::Loan> session = journal->writers_.Take();
    deleted = session.ok() ? journal->Prepare(**session) : session.status();
    if (!absl::IsUnavailable(deleted.status()) || absl::Now() >= end) break;
    if (session.ok()) (*session)->Spoil();
  }
  if (!deleted.ok()) return named(deleted.status());
  for (const Key mesh : *deleted) journal->SweepWhole(mesh);
  return journal;
}

absl::StatusOr<std::vector<std::int64_t>> PostgresJournal::Prepare(Session& session) {
  if (absl::Status s = postgres::CheckUse(session, options_); !s.ok()) return s;
  if (absl::Status s = postgres::PrepareSchema(session); !s.ok()) return s;
  if (is_shared()) {
    if (absl::Status s = postgres::PrepareLeases(session); !s.ok()) return s;
  }
  WarnOfUnsafeSettings(session, name_);
  Measure(session);
  return postgres::DeletedMeshes(session);
}

PostgresJournal::PostgresJournal(const postgres::Target& target, const Options& options)
    : name_(target.name),
      options_(options),
      owner_(FreshOwner()),
      writers_(target.conninfo, options.writing_connections, BetweenStatements(options)),
      readers_(target.conninfo, options.reading_connections, BetweenStatements(options)),
      keeper_(target.conninfo, 1, BetweenStatements(options)),
      follower_(target.conninfo, 2, BetweenStatements(options)) {}

void PostgresJournal::Measure(Session& session) {
  const Answer size = session.Execute(
      "SELECT sum(pg_total_relation_size(c.oid))::bigint FROM pg_class AS c JOIN pg_namespace AS n "
      "ON n.oid = c.relnamespace WHERE n.nspname = 'dynmesh' AND c.relkind = 'r'");
  if (size.status.ok() && !size.IsNull(0, 0)) {
    bytes_ = static_cast<std::uint64_t>(size.Integer(0, 0));
  }
}

absl::Status PostgresJournal::Counted(absl::Status status) {
  if (!under_way_.ended().ok()) return status;  // refused here
  const bool failed = absl::IsUnavailable(status) || absl::IsUnknown(status);
  if (!status.ok() && !failed) return status;  // the database works
  ++(failed ? failures_ : commits_);
  if (failing_.exchange(failed) == failed) return status;
  if (failed) {
    Log(LogLevel::kError, "journal_failed", {{"journal", name_}, {"error", status.message()}});
  } else {
    Log(LogLevel::kInfo, "journal_works_again", {{"journal", name_}});
  }
  return status;
}

PostgresJournal::OwnedPtr PostgresJournal::Find(Key mesh) {
  const MutexLock lock(owned_mutex_);
  const auto it = owned_.find(mesh);
  return it == owned_.end() ? nullptr : it->second;
}

void PostgresJournal::Keep(Key mesh, const postgres::Belief& belief,
                           std::chrono::nanoseconds claimed) {
  const auto owned = std::make_shared<Owned>(belief, claimed);
  const MutexLock lock(owned_mutex_);
  owned_[mesh] = owned;
}

absl::Status PostgresJournal::Repeatedly(const Step& step, bool* is_unknown) {
  const WritesUnderWay::Write write(under_way_);
  const absl::Duration limit =
      is_shared() ? std::min(options_.resolve_for, options_.lease) : options_.resolve_for;
  const std::chrono::nanoseconds end = BootTime() + absl::ToChronoNanoseconds(limit);
  for (int attempt = 0;; ++attempt) {
    absl::Status status;
    bool unknown = false;
    {
      const std::chrono::nanoseconds patience =
          is_shared() ? std::max(end - BootTime(), Patience()) : Patience();
      absl::StatusOr<postgres::Pool::Loan> session =
          attempt == 0 ? writers_.Take(patience) : writers_.TakeFresh(patience);
      // At the end of a drain nothing is begun any more, and an unknown outcome stays so.
      const absl::Status ended = under_way_.ended();
      if (!ended.ok()) {
        if (is_unknown != nullptr) *is_unknown = attempt > 0;
        return ended;
      }
      status = session.ok() ? step(**session, &unknown) : session.status();
      // Nothing was sent, unless by an earlier attempt.
      if (!session.ok()) unknown = attempt > 0;
    }
    if (!unknown || BootTime() > end) {
      if (is_unknown != nullptr) *is_unknown = unknown;
      return Counted(std::move(status));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20) * (1 << std::min(attempt, 5)));
  }
}

absl::Status PostgresJournal::Change(const Step& step) {
  bool is_unknown = false;
  const absl::Status status = Repeatedly(step, &is_unknown);
  if (!is_unknown) return status;
  return absl::UnknownError(
      absl::StrCat("it could not be found out whether the change was written: ", status.message()));
}

// ------------------------------------------------------------------ meshes

absl::StatusOr<std::vector<Journal::Mesh>> PostgresJournal::List() {
  absl::StatusOr<postgres::Pool::Loan> session = readers_.Take();
  if (!session.ok()) return session.status();
  return postgres::ListMeshes(**session);
}

absl::Status PostgresJournal::DrawKey(Session& session, Key* key, bool* unknown) const {
  if (*key != 0) return absl::OkStatus();
  const Answer next = session.Execute(kNextKey);
  *unknown = next.unknown;
  if (next.status.ok()) *key = next.Integer(0, 0);
  return next.status;
}

// The key is drawn first: so a repetition finds what an earlier attempt has made.
absl::StatusOr<Journal::Key> PostgresJournal::Create(const std::string& id,
                                                     const std::string& description) {
  Key key = 0;
  const std::int64_t sum = RowSumOf(absl::string_view(id), absl::string_view(description));
  std::chrono::nanoseconds sent{0};
  const absl::Status status = Change([&](Session& session, bool* unknown) -> absl::Status {
    if (absl::Status s = DrawKey(session, &key, unknown); !s.ok()) return s;
    const postgres::Bytes bytes{description};
    sent = BootTime();
    const Answer made = is_shared()
                            ? session.Run(kCreateLeased, key, id, bytes, sum, owner_,
                                          std::int64_t{absl::ToInt64Microseconds(options_.lease)})
                            : session.Run(kCreate, key, id, bytes, sum, owner_);
    *unknown = made.unknown;
    if (!made.status.ok() || !made.empty()) return made.status;
    const Answer there = session.Run("SELECT key FROM dynmesh.meshes WHERE id = $1::text", id);
    if (there.status.ok() && !there.empty() && there.Integer(0, 0) == key) return absl::OkStatus();
    return MeshExists(id);
  });
  if (!status.ok()) return status;
  Keep(key, {.epoch = 1}, sent);
  return key;
}

postgres::Claimed PostgresJournal::ClaimOn(Session& session, Key mesh) const {
  if (!is_shared()) return postgres::ClaimMesh(session, mesh, owner_);
  const postgres::FreeClaim claim = postgres::ClaimFree(session, mesh, owner_, options_.lease);
  if (!claim.held) return {claim.status, claim.unknown, claim.belief};
  return {absl::AbortedError(absl::StrCat("the server at ", claim.holder.node.address,
                                          " has the mesh, in epoch ", claim.holder.epoch)),
          false,
          {}};
}

absl::Status PostgresJournal::Claim(Key mesh) {
  // An append of an earlier claim ends first: it may have to claim the mesh again.
  const OwnedPtr before = Find(mesh);
  if (before == nullptr) return ClaimNow(mesh);
  const MutexLock lock(before->mutex);
  absl::Status status = ClaimNow(mesh);
  if (status.ok()) before->gone = absl::AbortedError("the mesh was claimed anew");
  return status;
}

absl::Status PostgresJournal::ClaimNow(Key mesh) {
  postgres::Belief belief;
  std::chrono::nanoseconds sent{0};
  absl::Status status = Repeatedly([&](Session& session, bool* unknown) {
    sent = BootTime();
    const postgres::Claimed claimed = ClaimOn(session, mesh);
    *unknown = claimed.unknown;
    belief = claimed.belief;
    return claimed.status;
  });
  if (status.ok()) Keep(mesh, belief, sent);
  return status;
}

absl::Status PostgresJournal::Delete(Key mesh) {
  bool repeated = false;
  const absl::Status status = Change([&](Session& session, bool* unknown) -> absl::Status {
    const Answer gone = session.Run(kDelete, mesh);
    *unknown = gone.unknown;
    if (!gone.status.ok()) {
      repeated = true;
      return gone.status;
    }
    if (gone.empty() && !repeated) return NoSuchMesh();
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  const MutexLock lock(owned_mutex_);
  owned_.erase(mesh);
  return status;
}

// ------------------------------------------------------------------ reading

absl::Status PostgresJournal::Read(Key mesh, const Visitor& visitor) {
  absl::StatusOr<postgres::Pool::Loan> session = readers_.Take(Patience());
  if (!session.ok()) return session.status();
  return postgres::ReadMesh(**session, mesh, options_.reading_idle, visitor);
}

absl::Status PostgresJournal::ReadPast(Key mesh, std::uint64_t from, std::uint64_t to,
                                       const Visitor& visitor) {
  absl::StatusOr<postgres::Pool::Loan> session = readers_.Take(Patience());
  if (!session.ok()) return session.status();
  return postgres::ReadPastOf(**session, mesh, options_.reading_idle, from, to, visitor);
}

absl::StatusOr<std::uint64_t> PostgresJournal::Oldest(Key mesh) {
  absl::StatusOr<postgres::Pool::Loan> session = readers_.Take(Patience());
  if (!session.ok()) return session.status();
  return postgres::OldestOf(**session, mesh);
}

}  // namespace dynmesh::server
