// The part of SqliteJournal that writes snapshots, between the appends of all meshes.
//
// A transaction of a snapshot, or of a deletion of what it replaces, is followed by a pause of the
// same length. So appends wait for one such transaction at most before they have the journal for
// themselves, and a snapshot does not slow them down by more than half.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <thread>

#include "server/journal/journal_errors.h"
#include "server/journal/sqlite_generations.h"
#include "server/journal/sqlite_journal.h"

namespace dynmesh::server {
namespace {

using Clock = std::chrono::steady_clock;
using sqlite::Statement;

// On a disk that hangs, a snapshot has waited enough.
constexpr std::chrono::milliseconds kLongestPause(250);

// For as long as what began then took.
void PauseAfter(Clock::time_point begun) {
  std::this_thread::sleep_for(std::min<Clock::duration>(Clock::now() - begun, kLongestPause));
}

}  // namespace

absl::Status SqliteJournal::CheckSnapshot(Key mesh, std::uint64_t revision, bool* there) {
  Statement find(writer_, "SELECT snapshot, head FROM meshes WHERE key = ?");
  if (!find.Bind(mesh).Step()) return find.status().ok() ? NoSuchMesh() : find.status();
  const auto at = static_cast<std::int64_t>(revision);
  const std::int64_t snapshot = find.Integer(0), head = find.Integer(1);
  *there = at == snapshot;
  if (*there || (at > snapshot && at <= head)) return absl::OkStatus();
  return NoSnapshotAt(revision);
}

absl::Status SqliteJournal::Compact(Key mesh, std::uint64_t revision,
                                    const std::vector<std::string>& parts,
                                    const std::atomic<bool>& cancelled) {
  if (absl::Status s = CheckWritable(mesh); !s.ok()) return s;
  bool there = false;
  absl::Status status = Write([&] { return CheckSnapshot(mesh, revision, &there); });
  if (!status.ok() || there) return status;
  SweepSlowly(mesh, cancelled);  // of an unfinished snapshot
  status = WriteSnapshot(mesh, revision, parts, cancelled);
  SweepSlowly(mesh, cancelled);
  return status;
}

absl::Status SqliteJournal::WriteSnapshot(Key mesh, std::uint64_t revision,
                                          const std::vector<std::string>& parts,
                                          const std::atomic<bool>& cancelled) {
  const auto at = static_cast<std::int64_t>(revision);
  bool there = false;
  for (std::size_t part = 0; part < parts.size();) {
    if (cancelled) return SnapshotEnded();
    const auto begun = Clock::now();
    const absl::Status status = Write([&]() -> absl::Status {
      if (absl::Status s = CheckSnapshot(mesh, revision, &there); !s.ok()) return s;
      const auto next = WriteParts(writer_, mesh, at, parts, part, options_.transaction_bytes);
      if (next.ok()) part = *next;
      return next.status();
    });
    if (!status.ok()) return status;
    PauseAfter(begun);
  }
  if (cancelled) return SnapshotEnded();
  return Write([&]() -> absl::Status {
    if (absl::Status s = CheckSnapshot(mesh, revision, &there); !s.ok()) return s;
    return SwitchOver(writer_, mesh, at, parts, options_.history_bytes);
  });
}

void SqliteJournal::SweepSlowly(Key mesh, const std::atomic<bool>& cancelled) {
  for (bool more = true; more && !cancelled;) {
    const auto begun = Clock::now();
    more = Sweep(mesh);
    if (more) PauseAfter(begun);
  }
}

}  // namespace dynmesh::server
