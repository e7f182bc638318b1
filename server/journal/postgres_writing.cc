// The writing part of PostgresJournal: appends, and the end of unknown ones.
#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/boot_time.h"
#include "server/base/log.h"
#include "server/journal/journal_errors.h"
#include "server/journal/postgres_journal.h"

namespace dynmesh::server {
namespace {

using postgres::Answer;
using postgres::Belief;
using postgres::GroupAppend;
using Loan = postgres::Pool::Loan;
using std::chrono::nanoseconds;

// A group is appended so often at most: it may be what breaks the connection.
constexpr int kAttempts = 3;

}  // namespace

// ------------------------------------------------------------------ appends

absl::Status PostgresJournal::Append(Key mesh, const std::vector<Entry>& entries,
                                     const std::vector<Request>& requests) {
  const WritesUnderWay::Write write(under_way_);
  const OwnedPtr owned = Find(mesh);
  if (owned == nullptr) return NotClaimed(mesh);
  const MutexLock lock(owned->mutex);
  if (!owned->gone.ok()) return owned->gone;
  std::int64_t last = owned->is.head;
  for (const Entry& entry : entries) {
    if (static_cast<std::int64_t>(entry.revision) != ++last) {
      return NotTheNextRevision(entry.revision, last - 1);
    }
  }
  const GroupAppend group(mesh, owned->is, entries, requests, options_.remembered_requests);
  return Counted(AppendGroup(mesh, *owned, group));
}

absl::Status PostgresJournal::NotClaimed(Key mesh) {
  absl::StatusOr<Loan> session = writers_.Take(Patience());
  if (!session.ok()) return session.status();
  return postgres::WhyRefused(**session, mesh, owner_, {});
}

nanoseconds PostgresJournal::LeaseLeft(const Owned& owned) const {
  const nanoseconds since = std::max(owned.claimed, nanoseconds(renewed_.load()));
  return since + absl::ToChronoNanoseconds(options_.lease) - BootTime();
}

// Some time in any case: the database may be there again although the lease has ended.
nanoseconds PostgresJournal::Patience() const {
  if (!is_shared()) return postgres::Pool::kUntilItEnds;
  return absl::ToChronoNanoseconds(std::max(options_.lease / 4, absl::Seconds(1)));
}

nanoseconds PostgresJournal::Patience(const Owned& owned) const {
  if (!is_shared()) return postgres::Pool::kUntilItEnds;
  return std::max(LeaseLeft(owned), absl::ToChronoNanoseconds(options_.lease / 10));
}

absl::Status PostgresJournal::AppendGroup(Key mesh, Owned& owned, const GroupAppend& group) {
  const nanoseconds end = BootTime() + absl::ToChronoNanoseconds(options_.resolve_for);
  absl::Status failure;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    {
      // Threads are few, and other meshes wait for one: after the lease only for a short time.
      absl::StatusOr<Loan> session = writers_.Take(std::min(Patience(), Patience(owned)));
      if (!session.ok()) return session.status();
      // What was sent earlier is known to be not there.
      if (absl::Status ended = under_way_.ended(); !ended.ok()) return ended;
      const Answer answer = group.Run(**session, owned.is.epoch);
      if (answer.status.ok() && !answer.empty()) {
        owned.is = group.After(owned.is.epoch);
        return absl::OkStatus();
      }
      if (answer.status.ok()) {
        return Disown(owned, postgres::WhyRefused(**session, mesh, owner_, owned.is));
      }
      failure = answer.status;
      if (!answer.unknown) return failure;
    }
    Log(LogLevel::kWarning, "append_unknown",
        {{"journal", name_}, {"mesh", mesh}, {"error", failure.message()}});
    bool is_there = false;
    if (absl::Status s = Resolve(mesh, owned, group, end, &is_there); !s.ok()) return s;
    if (is_there) return absl::OkStatus();
  }
  return failure;
}

// OK: it is known whether the group is there. If not, it never will be by an earlier attempt.
absl::Status PostgresJournal::Resolve(Key mesh, Owned& owned, const GroupAppend& group,
                                      nanoseconds end, bool* is_there) {
  absl::Status last;
  nanoseconds pause = std::chrono::milliseconds(20);
  while (true) {
    absl::StatusOr<Loan> session = writers_.TakeFresh(Patience(owned));
    last = session.status();
    if (session.ok()) {
      const postgres::Claimed claimed = postgres::ClaimAgain(**session, mesh, owner_);
      last = claimed.status;
      if (last.ok()) {
        const Belief after = group.After(claimed.belief.epoch), before = group.before();
        const auto is = [&claimed](const Belief& other) {
          return claimed.belief.head == other.head && claimed.belief.answers == other.answers;
        };
        *is_there = is(after);
        if (!*is_there && !is(before)) {
          return Disown(owned, postgres::SetBack(claimed.belief, before));
        }
        owned.is = claimed.belief;
        owned.epoch = owned.is.epoch;
        Log(LogLevel::kInfo, "append_resolved",
            {{"journal", name_}, {"mesh", mesh}, {"appended", *is_there}});
        return absl::OkStatus();
      }
      if (absl::IsNotFound(last)) return Disown(owned, last);
      // The other owner knows; this one cannot be sure.
      if (absl::IsAborted(last)) break;
    }
    const nanoseconds left =
        std::min(end - BootTime(), is_shared() ? LeaseLeft(owned) : nanoseconds::max());
    if (left <= nanoseconds::zero() || !under_way_.ended().ok()) break;
    std::this_thread::sleep_for(std::min(pause, left));
    pause = std::min<nanoseconds>(2 * pause, std::chrono::seconds(1));
  }
  return Disown(owned,
                absl::UnknownError(absl::StrCat(
                    "it could not be found out whether the change was written: ", last.message())));
}

absl::Status PostgresJournal::Disown(Owned& owned, absl::Status why) {
  if (absl::IsUnknown(why)) ++unknown_;
  if (absl::IsAborted(why)) ++fenced_;
  owned.gone = why;
  owned.epoch = 0;
  return why;
}

}  // namespace dynmesh::server
