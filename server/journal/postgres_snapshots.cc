// The part of PostgresJournal that writes snapshots, beside appends, also those to the same mesh.
#include <functional>

#include "server/base/log.h"
#include "server/journal/journal_errors.h"
#include "server/journal/postgres_generations.h"
#include "server/journal/postgres_journal.h"

namespace dynmesh::server {

using Loan = postgres::Pool::Loan;

absl::Status PostgresJournal::Compact(Key mesh, std::uint64_t revision,
                                      const std::vector<std::string>& parts,
                                      const std::atomic<bool>& cancelled) {
  const OwnedPtr owned = Find(mesh);
  if (owned == nullptr) return NotClaimed(mesh);
  absl::Status status = CompactIn(mesh, *owned, revision, parts, cancelled);
  // Without a database, other meshes' snapshots are not to wait. The next snapshot sweeps.
  if (cancelled || (is_shared() && absl::IsUnavailable(status))) return status;
  SweepWhole(mesh, &cancelled);
  if (absl::StatusOr<Loan> session = readers_.Take(Patience()); session.ok()) Measure(**session);
  return status;
}

absl::Status PostgresJournal::SnapshotStep(
    Owned& owned, std::uint64_t revision,
    const std::function<absl::Status(postgres::Session&, std::int64_t epoch)>& work) {
  const WritesUnderWay::Write write(under_way_);
  while (true) {
    std::int64_t epoch = 0;
    {
      const MutexLock lock(owned.mutex);
      if (!owned.gone.ok()) return owned.gone;
      if (static_cast<std::int64_t>(revision) > owned.is.head) return NoSnapshotAt(revision);
      epoch = owned.is.epoch;
    }
    absl::StatusOr<Loan> session = writers_.Take(Patience());
    if (absl::Status ended = under_way_.ended(); !ended.ok()) return ended;
    absl::Status status = Counted(session.ok() ? work(**session, epoch) : session.status());
    if (!absl::IsAborted(status)) return status;
    // An append with an unknown outcome may have claimed the mesh again.
    const MutexLock lock(owned.mutex);
    if (!owned.gone.ok()) return owned.gone;
    if (owned.is.epoch == epoch) return status;
  }
}

absl::Status PostgresJournal::CompactIn(Key mesh, Owned& owned, std::uint64_t revision,
                                        const std::vector<std::string>& parts,
                                        const std::atomic<bool>& cancelled) {
  const auto at = static_cast<std::int64_t>(revision);
  bool there = false;
  absl::Status status =
      SnapshotStep(owned, revision, [&](postgres::Session& session, std::int64_t) {
        const auto found = postgres::CheckSnapshot(session, mesh, at);
        there = found.ok() && *found;
        return found.status();
      });
  if (!status.ok() || there) return status;
  SweepWhole(mesh, &cancelled);  // of an unfinished snapshot
  for (std::size_t part = 0; part < parts.size();) {
    if (cancelled) return SnapshotEnded();
    status = SnapshotStep(owned, revision, [&](postgres::Session& session, std::int64_t epoch) {
      const auto next =
          postgres::WriteParts(session, mesh, epoch, at, parts, part, options_.transaction_bytes);
      if (next.ok()) part = *next;
      return next.status();
    });
    if (!status.ok()) return status;
  }
  if (cancelled) return SnapshotEnded();
  return SnapshotStep(owned, revision, [&](postgres::Session& session, std::int64_t epoch) {
    return postgres::SwitchOver(session, mesh, epoch, at, parts, options_.history_bytes);
  });
}

// After a failure the rest is left for the next time.
bool PostgresJournal::Sweep(Key mesh) {
  std::int64_t epoch = 0;  // no mesh has it
  if (const OwnedPtr owned = Find(mesh); owned != nullptr) {
    const MutexLock lock(owned->mutex);
    if (owned->gone.ok()) epoch = owned->is.epoch;
  }
  absl::StatusOr<Loan> session = writers_.Take(Patience());
  const absl::StatusOr<bool> more =
      session.ok() ? postgres::SweepPart(**session, mesh, epoch, options_.transaction_bytes)
                   : absl::StatusOr<bool>(session.status());
  if (more.ok()) return *more;
  Log(LogLevel::kWarning, "sweep_failed", {{"journal", name_}, {"error", more.status().message()}});
  return false;
}

void PostgresJournal::SweepWhole(Key mesh, const std::atomic<bool>* cancelled) {
  while ((cancelled == nullptr || !*cancelled) && Sweep(mesh)) {
  }
}

}  // namespace dynmesh::server
