#include "server/meshes/followers.h"

#include <algorithm>
#include <future>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/log.h"
#include "server/base/mesh_name.h"

namespace dynmesh::server {
namespace {

// Reading a mesh waits for the database.
constexpr int kFollowingThreads = 2;
// A server that has just started makes many meshes, and so do the others after a drain. Writers go
// first: these threads have a low priority, which does not count beside other processes, and rest
// after a mesh for three times as long as that took. So they need half a core.
constexpr int kRest = 3;
constexpr std::chrono::milliseconds kMostRest(300);
// A second mismatch is not an accident of this process.
constexpr int kMostMismatches = 2;
// Of a mesh that has not been read yet: nothing comes after it.
constexpr std::uint64_t kEverything = std::numeric_limits<std::int64_t>::max();

// Between looks without a mesh that is followed or may be: what is added kicks.
constexpr std::chrono::minutes kNothing(1);

using Position = SharedJournal::Position;
using Tail = SharedJournal::Tail;

bool HasNews(const Tail& tail) { return !tail.entries.empty() || !tail.requests.empty(); }

Position After(const Position& before, const Tail& tail) {
  Position after = before;
  if (!tail.entries.empty()) after.revision = tail.entries.back().revision;
  after.answers = tail.answers;
  return after;
}

}  // namespace

Followers::Followers(SharedJournal* journal, std::string address, const Options& options,
                     Calls calls, FollowerMetrics* metrics)
    : journal_(journal),
      address_(std::move(address)),
      options_(options),
      calls_(std::move(calls)),
      metrics_(metrics),
      pool_(kFollowingThreads, WorkerPool::Priority::kBackground) {
  life_->it = this;
  thread_ = std::thread([this] { Run(); });
}

void Followers::Kick() {
  {
    const MutexLock lock(mutex_);
    kick_ = true;
  }
  kicked_.NotifyOne();
  idle_.NotifyAll();
}

bool Followers::IsThereLocked(const FollowerPtr& follower) const {
  const auto it = by_id_.find(follower->id);
  return it != by_id_.end() && it->second == follower;
}

// ------------------------------------------------------------------ reads

void Followers::Read(const std::string& id, std::uint64_t min_revision, Clock::time_point end,
                     Done done) {
  HostPtr host;
  MeshOwner owner;
  {
    const MutexLock lock(mutex_);
    const auto it = by_id_.find(id);
    const FollowerPtr follower = it != by_id_.end() ? it->second : AddLocked(id);
    if (follower != nullptr) {
      follower->used = Clock::now();
      if (follower->host == nullptr) {
        follower->waiters.push_back({min_revision, end, std::move(done)});
        return;
      }
      host = follower->host;
      owner = follower->owner;
    }
  }
  if (host == nullptr) return done(NotOwnerError(id));  // it ends
  if (host->head().revision < min_revision) Kick();
  host->WhenAt(min_revision, end, [id, owner, host, done = std::move(done)](bool reached) {
    done(reached ? absl::StatusOr<HostPtr>(host) : NotOwnerError(id, owner));
  });
}

// Null after Settle.
Followers::FollowerPtr Followers::AddLocked(const std::string& id) {
  if (settled_ || stopped_) return nullptr;
  const auto follower = std::make_shared<Follower>();
  follower->id = id;
  follower->used = follower->caught_up = Clock::now();
  by_id_[id] = follower;
  kick_ = true;
  kicked_.NotifyOne();
  pool_.Post([this, follower] {
    const Clock::time_point begin = Clock::now();
    OpenOne(follower);
    Rest(Clock::now() - begin);
  });
  return follower;
}

void Followers::Rest(Clock::duration worked) {
  const MutexLock lock(mutex_);
  idle_.WaitFor(mutex_, std::min<Clock::duration>(kRest * worked, kMostRest),
                [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return settled_; });
}

absl::Status Followers::CheckRoomLocked(const Follower& follower) const {
  if (settled_) return absl::UnavailableError("nothing new is followed");
  if (by_id_.size() > options_.max_meshes) {
    return absl::ResourceExhaustedError("as many meshes are followed as may be");
  }
  const auto mismatches = mismatches_.find(follower.mesh.key);
  if (mismatches != mismatches_.end() && mismatches->second >= kMostMismatches) {
    return absl::FailedPreconditionError("its revisions differ here from the journal's");
  }
  return absl::OkStatus();
}

absl::Status Followers::LookUp(const FollowerPtr& follower, bool* is_free) {
  const absl::StatusOr<SharedJournal::Located> located = journal_->Locate(follower->id);
  if (absl::IsNotFound(located.status())) {
    return MeshNotFoundError(follower->id);
  }
  if (!located.ok()) return JournalReadError(located.status(), follower->id);
  *is_free = located->is_mine || located->left <= absl::ZeroDuration();
  if (*is_free) return absl::OkStatus();
  const MeshOwner owner{located->address, located->epoch};
  absl::Status room = calls_.check_room == nullptr ? absl::OkStatus() : calls_.check_room();
  const MutexLock lock(mutex_);
  follower->mesh = located->mesh;
  follower->owner = owner;
  if (room.ok()) room = CheckRoomLocked(*follower);
  return room.ok() ? room : NotOwnerError(follower->id, owner);
}

void Followers::OpenOne(const FollowerPtr& follower) {
  bool is_free = false;
  absl::Status status = LookUp(follower, &is_free);
  HostPtr host;
  Position position;
  if (status.ok() && !is_free) {
    const Journal::Key key = follower->mesh.key;
    // First: requests that come meanwhile are read twice rather than never.
    const auto before = journal_->ReadTails({{key, kEverything, INT64_MAX}});
    absl::StatusOr<HostPtr> made = before.ok() ? calls_.make(follower->mesh) : before.status();
    if (made.ok()) {
      host = *std::move(made);
      journal_->SetFollows(key, true).IgnoreError();  // a hint for others
      position = {key, host->head().revision, before->empty() ? 0 : before->front().answers};
      Log(LogLevel::kInfo, "follows",
          {{"mesh", follower->id},
           {"revision", position.revision},
           {"owner", follower->owner.address}});
    } else {
      Distrust(follower, made.status());
      status = NotOwnerError(follower->id, follower->owner);
    }
  }
  std::vector<Waiter> waiters;
  bool is_there = false;
  {
    const MutexLock lock(mutex_);
    is_there = IsThereLocked(follower);
    waiters.swap(follower->waiters);
    if (is_there && host != nullptr) {
      follower->host = host;
      follower->position = position;
      follower->caught_up = Clock::now();
      follower->busy = false;
    } else if (is_there) {
      by_id_.erase(follower->id);
    }
  }
  if (!is_there && host != nullptr) {
    journal_->SetFollows(follower->mesh.key, false).IgnoreError();
    host->Close(NotOwnerError(follower->id));
    host = nullptr;
    status = NotOwnerError(follower->id);
  }
  for (Waiter& waiter : waiters) {
    if (host == nullptr) {
      waiter.done(status.ok() ? absl::StatusOr<HostPtr>(HostPtr()) : status);
    } else {
      Read(follower->id, waiter.min_revision, waiter.end, std::move(waiter.done));
    }
  }
  Kick();
}

void Followers::Drop(const FollowerPtr& follower, const absl::Status& status) {
  std::vector<Waiter> waiters;
  HostPtr host;
  {
    const MutexLock lock(mutex_);
    if (!IsThereLocked(follower)) return;
    by_id_.erase(follower->id);
    waiters.swap(follower->waiters);
    host = std::move(follower->host);
  }
  idle_.NotifyAll();
  if (host != nullptr) host->Close(status);
  for (const Waiter& waiter : waiters) waiter.done(status);
  // A large mesh takes long to free.
  pool_.Post([this, host, key = follower->mesh.key] {
    if (key != 0) journal_->SetFollows(key, false).IgnoreError();
  });
}

void Followers::Distrust(const FollowerPtr& follower, const absl::Status& status) {
  if (absl::IsUnimplemented(status)) {
    // Another version writes the mesh: as after two mismatches, but nothing is wrong.
    Log(LogLevel::kInfo, "not_followed", {{"mesh", follower->id}, {"reason", status.message()}});
    const MutexLock lock(mutex_);
    mismatches_[follower->mesh.key] = kMostMismatches;
    return;
  }
  if (!absl::IsDataLoss(status)) {
    if (absl::IsNotFound(status) || absl::IsCancelled(status)) return;
    Log(LogLevel::kWarning, "not_followed", {{"mesh", follower->id}, {"reason", status.message()}});
    return;
  }
  if (metrics_ != nullptr) metrics_->mismatches.Add();
  int times = 0;
  {
    const MutexLock lock(mutex_);
    times = ++mismatches_[follower->mesh.key];
  }
  Log(LogLevel::kError, "follower_mismatch",
      {{"mesh", follower->id},
       {"error", status.message()},
       {"next", times < kMostMismatches ? "it is read again" : "it is not followed any more"}});
}

// ------------------------------------------------------------------ the journal's news

void Followers::Run() {
  of_thread_.AssertHeld();
  Clock::time_point next_look = Clock::now();
  MutexLock lock(mutex_);
  while (!stopped_) {
    kick_ = false;
    const bool looks = options_.per_mesh > 0 && !settled_ && Clock::now() >= next_look;
    lock.Unlock();
    if (looks) {
      Ask();
      TakeWishes();
      next_look = Clock::now() + options_.ask;
    }
    const bool news = Poll();
    Expire();
    DropUnused(Clock::now());
    lock.Lock();
    Clock::time_point next = Clock::now() + (news ? options_.poll_after_news : options_.poll);
    if (by_id_.empty()) next = options_.per_mesh > 0 && !settled_ ? next_look : next + kNothing;
    kicked_.WaitUntil(mutex_, next,
                      [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return kick_ || stopped_; });
  }
}

bool Followers::Poll() {
  std::vector<Position> positions;
  std::map<Journal::Key, FollowerPtr> asked;
  {
    const MutexLock lock(mutex_);
    for (const auto& [id, follower] : by_id_) {
      if (follower->busy) continue;
      positions.push_back(follower->position);
      asked[follower->position.mesh] = follower;
    }
  }
  if (positions.empty()) return false;
  const absl::StatusOr<std::vector<Tail>> tails = journal_->ReadTails(positions);
  if (tails.ok() == failing_) {
    failing_ = !tails.ok();
    Log(failing_ ? LogLevel::kWarning : LogLevel::kInfo,
        failing_ ? "followers_wait" : "followers_go_on", {{"error", tails.status().message()}});
  }
  bool news = false;
  if (tails.ok()) {
    for (const Tail& tail : *tails) news = Judge(asked.at(tail.mesh), tail) || news;
  }
  return news;
}

bool Followers::Judge(const FollowerPtr& follower, const Tail& tail) {
  const bool applies = HasNews(tail) && tail.damage.ok();
  bool takes = false;
  HostPtr host;
  {
    const MutexLock lock(mutex_);
    if (follower->busy || !IsThereLocked(follower)) return false;  // it is taken over meanwhile
    host = follower->host;
    follower->head = tail.head;
    if (tail.exists) follower->owner = {tail.address, tail.epoch};
    if (tail.head == follower->position.revision) follower->caught_up = Clock::now();
    takes = tail.exists && tail.damage.ok() && !applies && (tail.is_mine || tail.is_free) &&
            !follower->taking && !settled_;
    follower->busy = applies;
    follower->taking = follower->taking || takes;
  }
  if (!tail.exists) {
    Drop(follower, MeshDeletedError(follower->id));
  } else if (!tail.damage.ok()) {
    // OUT_OF_RANGE: the journal has left this follower behind.
    Distrust(follower, tail.damage);
    Drop(follower, NotOwnerError(follower->id, follower->owner));
  } else if (applies) {
    const Position reached = After(follower->position, tail);
    host->Follow(tail, [life = life_, follower, reached](const absl::Status& status) {
      const MutexLock lock(life->mutex);
      if (life->it != nullptr) life->it->Applied(follower, reached, status);
    });
  } else if (takes) {
    calls_.take_over(follower->id, [this, follower] { EndTaking(follower); });
  }
  return applies;
}

void Followers::EndTaking(const FollowerPtr& follower) {
  const MutexLock lock(mutex_);
  follower->taking = false;
}

// On the mesh's strand.
void Followers::Applied(const FollowerPtr& follower, const Position& reached,
                        const absl::Status& status) {
  if (status.ok()) {
    {
      const MutexLock lock(mutex_);
      follower->position = reached;
      const Clock::time_point now = Clock::now();
      if (follower->wanted) follower->used = now;
      if (follower->head <= reached.revision) follower->caught_up = now;
      follower->busy = false;
      // Behind still: at once.
      if (follower->head > reached.revision) kick_ = true;
    }
    kicked_.NotifyOne();
    idle_.NotifyAll();
    return;
  }
  Distrust(follower, status);
  Drop(follower, NotOwnerError(follower->id, follower->owner));
}

void Followers::Expire() {
  const Clock::time_point now = Clock::now();
  std::vector<std::pair<absl::Status, Done>> late;
  std::vector<HostPtr> hosts;
  {
    const MutexLock lock(mutex_);
    for (const auto& [id, follower] : by_id_) {
      if (follower->host != nullptr) hosts.push_back(follower->host);
      auto& waiters = follower->waiters;
      for (Waiter& waiter : waiters) {
        if (waiter.end > now) continue;
        late.emplace_back(NotOwnerError(id, follower->owner), std::move(waiter.done));
      }
      std::erase_if(waiters, [now](const Waiter& w) { return w.end <= now; });
    }
  }
  for (const HostPtr& host : hosts) host->ExpireWaiters(now);
  for (const auto& [status, done] : late) done(status);
}

// ------------------------------------------------------------------ take-over

absl::Status Followers::Apply(const HostPtr& host, const Tail& tail) {
  const auto applied = std::make_shared<std::promise<absl::Status>>();
  std::future<absl::Status> end = applied->get_future();
  host->Follow(tail, [applied](absl::Status s) { applied->set_value(std::move(s)); });
  // The writers may have ended.
  while (end.wait_for(options_.poll) != std::future_status::ready) {
    const MutexLock lock(mutex_);
    if (stopped_) return absl::UnavailableError("the server has ended");
  }
  return end.get();
}

absl::StatusOr<Followers::HostPtr> Followers::TakeOver(const Journal::Mesh& mesh,
                                                       const std::function<absl::Status()>& claim) {
  FollowerPtr follower;
  {
    const MutexLock lock(mutex_);
    const auto it = by_id_.find(mesh.id);
    if (it == by_id_.end() || stopped_) return HostPtr();
    follower = it->second;
    if (follower->host == nullptr) {
      // It is read a second time, by its owner: that is simpler than to wait for this reading.
      by_id_.erase(it);
      return HostPtr();
    }
    // Applying ends: each batch has ended before, at the owner.
    idle_.Wait(mutex_, [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return !follower->busy || !IsThereLocked(follower) || stopped_;
    });
    if (!IsThereLocked(follower) || stopped_ || follower->mesh.key != mesh.key) return HostPtr();
    follower->busy = true;
  }
  absl::Status status = claim();
  while (status.ok()) {
    const absl::StatusOr<std::vector<Tail>> tails = journal_->ReadTails({follower->position});
    status = tails.status();
    if (!status.ok()) break;
    const Tail& tail = tails->front();
    status = tail.exists ? tail.damage : absl::NotFoundError("the mesh was deleted");
    if (!status.ok()) break;
    if (!HasNews(tail) && tail.head == follower->position.revision) {
      const MutexLock lock(mutex_);
      by_id_.erase(follower->id);
      follower->host->Lead();
      if (metrics_ != nullptr) metrics_->takeovers.Add();
      pool_.Post([this, key = mesh.key] { journal_->SetFollows(key, false).IgnoreError(); });
      return follower->host;
    }
    status = Apply(follower->host, tail);
    if (status.ok()) follower->position = After(follower->position, tail);
  }
  if (absl::IsAborted(status) || absl::IsUnavailable(status) || absl::IsUnknown(status)) {
    {
      const MutexLock lock(mutex_);
      follower->busy = follower->taking = false;
    }
    Kick();
    return status;
  }
  Distrust(follower, status);
  Drop(follower, NotOwnerError(follower->id));
  return HostPtr();  // the reading of the mesh tells what is wrong
}

// ------------------------------------------------------------------ all of them

std::vector<Followers::Followed> Followers::List() const {
  const Clock::time_point now = Clock::now();
  std::vector<Followed> list;
  const MutexLock lock(mutex_);
  for (const auto& [id, follower] : by_id_) {
    if (follower->host == nullptr) continue;
    const std::uint64_t has = follower->host->head().revision;
    Followed followed{follower->host, follower->head > has ? follower->head - has : 0, 0};
    // An answer of the journal that is missing counts, too.
    const Clock::duration since = now - follower->caught_up;
    if (followed.behind > 0 || since > 4 * options_.poll) {
      followed.lag_seconds = std::chrono::duration<double>(since).count();
    }
    list.push_back(std::move(followed));
  }
  return list;
}

void Followers::Settle() {
  {
    const MutexLock lock(mutex_);
    settled_ = true;
  }
  idle_.NotifyAll();
}

void Followers::CloseWatches(const absl::Status& status) {
  for (const Followed& followed : List()) followed.host->hub()->Close(status);
}

void Followers::Stop() {
  std::vector<FollowerPtr> followers;
  {
    const MutexLock lock(mutex_);
    settled_ = true;
    if (std::exchange(stopped_, true)) return;
    for (const auto& [id, follower] : by_id_) followers.push_back(follower);
  }
  kicked_.NotifyAll();
  idle_.NotifyAll();
  thread_.join();
  {
    const MutexLock lock(life_->mutex);
    life_->it = nullptr;
  }
  pool_.Stop();
  for (const FollowerPtr& follower : followers) {
    Drop(follower, absl::UnavailableError("the server has ended"));
  }
}

}  // namespace dynmesh::server
