#include "server/meshes/mesh_opener.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "proto/codec/status_codec.h"
#include "server/cluster/placement.h"

namespace dynmesh::server {
namespace {

// Looking up a mesh and reading it wait for the database.
constexpr int kOpeningThreads = 4;
// A call that was sent on so often is served here if it can be.
constexpr int kMostRedirects = 2;
constexpr int kMostLost = 3;
// So often, and for so long, a free mesh is left to nodes that follow it.
constexpr int kMostLeft = 4;
constexpr std::chrono::milliseconds kLeaveFor(100);
// After the end of a lease, for the database's clock to be past it.
constexpr absl::Duration kPast = absl::Milliseconds(2);

absl::Status TooLate(absl::string_view id) {
  return absl::DeadlineExceededError(
      absl::StrCat(MeshName(id), " was not open in time: nothing was changed"));
}

bool IsSentOn(const Asking& asking) {
  return asking.redirects != Asking::kFollowsNone && asking.redirects < kMostRedirects;
}

}  // namespace

MeshOpener::MeshOpener(SharedJournal* journal, std::string address, Load load)
    : journal_(journal),
      address_(std::move(address)),
      load_(std::move(load)),
      pool_(kOpeningThreads),
      timer_([this] { RunTimer(); }) {}

void MeshOpener::Open(const std::string& id, const Asking& asking, Done done) {
  absl::Status closed;
  {
    const MutexLock lock(mutex_);
    closed = closed_;
    if (closed.ok()) {
      Opening& opening = openings_[id];
      opening.waiters.push_back({asking, std::move(done)});
      if (opening.waiters.size() == 1 && !opening.running) {
        Queue(id, opening);
      }
      changed_.NotifyOne();  // it may have the earliest deadline
    }
  }
  if (!closed.ok()) done(closed);
}

std::vector<MeshOpener::Waiter> MeshOpener::Take(
    Opening& opening, const std::function<bool(const Waiter&)>& is_meant) {
  const auto first = std::stable_partition(opening.waiters.begin(), opening.waiters.end(),
                                           [&](const Waiter& w) { return !is_meant(w); });
  std::vector<Waiter> taken(std::make_move_iterator(first),
                            std::make_move_iterator(opening.waiters.end()));
  opening.waiters.erase(first, opening.waiters.end());
  return taken;
}

void MeshOpener::Queue(const std::string& id, Opening& opening) {
  opening.running = opening.queued = true;
  pool_.Post([this, id] { Step(id); });
}

std::vector<std::pair<std::string, MeshOpener::Waiter>> MeshOpener::TakeAll(bool queued_only) {
  std::vector<std::pair<std::string, Waiter>> taken;
  for (auto& [id, opening] : openings_) {
    if (queued_only && !opening.queued) continue;
    for (Waiter& waiter : Take(opening, [](const Waiter&) { return true; })) {
      taken.emplace_back(id, std::move(waiter));
    }
  }
  return taken;
}

void MeshOpener::Step(const std::string& id) {
  bool claims = false;
  Opening before;
  {
    const MutexLock lock(mutex_);
    Opening& opening = openings_[id];
    opening.queued = false;
    before.lost = opening.lost;
    before.left = opening.left;
    claims = opening.waited || std::any_of(opening.waiters.begin(), opening.waiters.end(),
                                           [](const Waiter& w) { return !IsSentOn(w.asking); });
    if (opening.waiters.empty()) {
      openings_.erase(id);
      return;
    }
  }
  Found found = Look(id, claims, before);
  std::vector<Waiter> answered;
  std::vector<std::pair<std::string, Waiter>> failed;
  {
    const MutexLock lock(mutex_);
    if (!found.failure.ok()) failed = TakeAll(/*queued_only=*/true);
    Opening& opening = openings_[id];
    if (found.again > Clock::duration::zero()) {
      if (absl::IsAborted(found.answer.status())) {
        ++opening.lost;
      } else {
        opening.waited = true;
      }
      if (found.is_left) ++opening.left;
      opening.running = false;
      opening.next = Clock::now() + found.again;
      changed_.NotifyOne();
    } else {
      answered = Take(opening, [&found](const Waiter& w) {
        return !found.only_followers || IsSentOn(w.asking);
      });
      opening.running = !opening.waiters.empty();
      if (opening.running) {
        Queue(id, opening);
      } else {
        openings_.erase(id);
      }
    }
  }
  for (const Waiter& waiter : answered) waiter.done(found.answer);
  for (const auto& [other, waiter] : failed) waiter.done(JournalReadError(found.failure, other));
}

MeshOpener::Found MeshOpener::Look(const std::string& id, bool claims, const Opening& before) {
  const absl::StatusOr<SharedJournal::Located> located = journal_->Locate(id);
  if (absl::IsNotFound(located.status())) return {MeshNotFoundError(id)};
  if (!located.ok()) {
    Found found{JournalReadError(located.status(), id)};
    found.failure = located.status();
    return found;
  }
  Found found = LookAt(id, *located, claims, before.left);
  // The next look finds the node that was granted the claim.
  if (absl::IsAborted(found.answer.status()) && !codec::GetServiceError(found.answer.status())) {
    if (before.lost < kMostLost) {
      found.again = std::chrono::milliseconds(1);
    } else {
      found.answer = NotOwnerError(id);
    }
  }
  return found;
}

MeshOpener::Found MeshOpener::LookAt(const std::string& id, const SharedJournal::Located& located,
                                     bool claims, int left) {
  const absl::Duration lease = journal_->lease();
  const bool is_held = !located.is_mine && located.left > absl::ZeroDuration();
  // An owner that renews leaves about half of it (lease_keeper.h).
  if (is_held && located.left > 0.4 * lease) {
    return {NotOwnerError(id, {located.address, located.epoch})};
  }
  if (!located.is_mine && !claims) {
    const std::string chosen = Chosen(id, located);
    if (chosen != address_) {
      return {NotOwnerError(id, {chosen, located.epoch}), /*only_followers=*/true};
    }
  }
  if (is_held) {
    const absl::Duration again = std::min(located.left + kPast, lease / 10);
    return {HostPtr(), false, absl::ToChronoNanoseconds(again)};
  }
  // They have it in memory, and look for it every 50 ms.
  const auto& followers = located.followers;
  const bool follows = std::find(followers.begin(), followers.end(), address_) != followers.end();
  if (!located.is_mine && !followers.empty() && !follows && left < kMostLeft) {
    return {HostPtr(), false, kLeaveFor, /*is_left=*/true};
  }
  return {load_(located.mesh)};
}

std::string MeshOpener::Chosen(const std::string& id, const SharedJournal::Located& located) const {
  absl::StatusOr<std::vector<std::string>> nodes = located.followers;
  if (nodes->empty()) nodes = journal_->LiveNodes();
  if (!nodes.ok()) return address_;
  if (located.address != address_) std::erase(*nodes, located.address);
  const auto chosen = ChooseNode(*nodes, id);
  return chosen.has_value() ? (*nodes)[*chosen] : address_;
}

void MeshOpener::RunTimer() {
  MutexLock lock(mutex_);
  while (!stopped_) {
    const Clock::time_point now = Clock::now();
    Clock::time_point next = now + std::chrono::hours(1);
    std::vector<std::pair<std::string, Done>> late;
    for (auto& [id, opening] : openings_) {
      for (Waiter& waiter :
           Take(opening, [now](const Waiter& w) { return w.asking.deadline <= now; })) {
        late.emplace_back(id, std::move(waiter.done));
      }
      for (const Waiter& waiter : opening.waiters) next = std::min(next, waiter.asking.deadline);
      if (opening.running) continue;
      if (opening.next <= now) {
        Queue(id, opening);
      } else {
        next = std::min(next, opening.next);
      }
    }
    if (!late.empty()) {
      lock.Unlock();
      for (const auto& [id, done] : late) done(TooLate(id));
      late.clear();
      lock.Lock();
      continue;
    }
    changed_.WaitUntil(mutex_, next);
  }
}

void MeshOpener::Close(const absl::Status& status) {
  std::vector<std::pair<std::string, Waiter>> waiters;
  {
    const MutexLock lock(mutex_);
    if (closed_.ok()) closed_ = status;
    waiters = TakeAll(/*queued_only=*/false);
  }
  for (const auto& [id, waiter] : waiters) waiter.done(status);
}

void MeshOpener::Stop() {
  Close(absl::UnavailableError("the server has ended"));
  {
    const MutexLock lock(mutex_);
    if (std::exchange(stopped_, true)) return;
  }
  changed_.NotifyAll();
  timer_.join();
  pool_.Stop();
}

}  // namespace dynmesh::server
