#include "server/meshes/watch_hub.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "server/revisions/diff_algebra.h"
#include "server/revisions/revision_error.h"

namespace dynmesh::server {
namespace {

constexpr absl::Duration kLeastProgressInterval = absl::Milliseconds(100);
// Watchers woken by one task of the pool: large enough to be cheap, small enough that two threads
// share the work of a few hundred.
constexpr std::size_t kWakeSlice = 32;

}  // namespace

std::shared_ptr<WatchHub> WatchHub::Create(std::shared_ptr<RevisionStore> store, WorkerPool* pool,
                                           Options options) {
  return std::shared_ptr<WatchHub>(new WatchHub(std::move(store), pool, options));
}

absl::Status WatchHub::CheckStart(const Start& start) const {
  if (!start.revision.has_value()) return absl::OkStatus();
  const Head head = store_->head();
  const std::uint64_t oldest = store_->oldest();
  if (*start.revision > head.revision) {
    return FutureRevision(*start.revision, head, oldest, kWatchWithout);
  }
  const std::optional<MeshHash> hash = store_->HashAt(*start.revision);
  if (!hash.has_value()) {
    return CompactedRevision(*start.revision, head, oldest, kWatchWithout);
  }
  if (start.hash.has_value() && *start.hash != *hash) {
    return DivergedRevision(*start.revision, *hash, *start.hash, head, oldest, kWatchWithout);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<Subscription>> WatchHub::Subscribe(const Start& start,
                                                                  std::function<void()> wake) {
  if (absl::Status status = CheckStart(start); !status.ok()) return status;
  std::shared_ptr<Subscription> s(new Subscription(shared_from_this(), std::move(wake)));
  s->cursor_ = start.revision;
  // A watcher that resumes gets each past revision. Other watchers may lag and get coalesced diffs.
  if (start.revision.has_value()) s->replay_until_ = store_->head().revision;
  const MutexLock lock(mutex_);
  if (!closed_.ok()) return closed_;
  s->hub_->mutex_.AssertHeld();  // this one
  s->progress_interval_ = start.progress_interval > absl::ZeroDuration()
                              ? std::max(start.progress_interval, kLeastProgressInterval)
                              : options_.progress_interval;
  ++size_;
  return s;
}

void WatchHub::Wake(Subscriptions subscriptions) {
  std::vector<std::shared_ptr<Subscription>> slice;
  std::size_t left = subscriptions.size();
  while (!subscriptions.empty()) {
    slice.push_back(std::move(subscriptions.extract(subscriptions.begin()).value()));
    --left;
    if (slice.size() == kWakeSlice || left == 0) {
      pool_->Post([woken = std::move(slice)] {
        for (const auto& s : woken) s->wake_();
      });
      slice.clear();
    }
  }
}

void WatchHub::Notify() {
  Subscriptions woken;
  {
    const MutexLock lock(mutex_);
    woken.swap(idle_);
  }
  Wake(std::move(woken));
}

void WatchHub::Tick(absl::Time now) {
  Subscriptions woken;
  {
    const MutexLock lock(mutex_);
    const bool first = now_ == absl::InfinitePast();
    now_ = now;
    for (const auto& s : idle_) {
      s->hub_->mutex_.AssertHeld();  // this one, and below
      if (first) s->idle_since_ = now;
      if (now - s->idle_since_ >= s->progress_interval_) woken.insert(s);
    }
    for (const auto& s : woken) {
      s->hub_->mutex_.AssertHeld();
      s->progress_due_ = true;
      idle_.erase(s);
    }
  }
  Wake(std::move(woken));
}

void WatchHub::Close(absl::Status status) {
  Subscriptions woken;
  {
    const MutexLock lock(mutex_);
    if (!closed_.ok()) return;
    closed_ = std::move(status);
    woken.swap(idle_);
  }
  Wake(std::move(woken));
}

std::size_t WatchHub::size() const {
  const MutexLock lock(mutex_);
  return size_;
}

std::size_t WatchHub::idle() const {
  const MutexLock lock(mutex_);
  return idle_.size();
}

WatchHub::Counts WatchHub::counts() const {
  const MutexLock lock(mutex_);
  return {size_ - idle_.size(), coalesced_.load(std::memory_order_relaxed),
          resynced_.load(std::memory_order_relaxed)};
}

Subscription::Step Subscription::Next(WatchItem* item) {
  const MutexLock lock(hub_->mutex_);
  if (cancelled_) {
    item->emplace<absl::Status>(absl::CancelledError("the watch was cancelled"));
    return Step::kItem;
  }
  if (!hub_->closed_.ok()) {
    item->emplace<absl::Status>(hub_->closed_);
    return Step::kItem;
  }
  if (!cursor_.has_value()) return Step::kWork;
  const Head head = hub_->store_->head();
  if (*cursor_ < head.revision) {
    progress_due_ = false;
    const bool lags = *cursor_ >= replay_until_ && head.revision - *cursor_ > hub_->options_.queue;
    std::shared_ptr<const MeshDiff> diff;
    if (!lags) diff = hub_->store_->DiffFrom(*cursor_);
    if (diff == nullptr) return Step::kWork;
    cursor_ = diff->to_revision;
    item->emplace<std::shared_ptr<const MeshDiff>>(std::move(diff));
    return Step::kItem;
  }
  if (progress_due_) {
    progress_due_ = false;
    item->emplace<Head>(head);
    return Step::kItem;
  }
  idle_since_ = hub_->now_;
  hub_->idle_.insert(shared_from_this());
  return Step::kIdle;
}

WatchItem Subscription::Snapshot(std::uint64_t newer_than) {
  // The base costs nothing and all new or lagging watchers share it; later diffs follow. Not used
  // if it is not newer than what the watcher has.
  std::shared_ptr<const Mesh> mesh = hub_->store_->base();
  if (cursor_.has_value() && mesh->revision <= newer_than) {
    auto latest = hub_->store_->Latest();
    if (!latest.ok()) return latest.status();
    mesh = *std::move(latest);
  }
  if (cursor_.has_value()) hub_->resynced_.fetch_add(1, std::memory_order_relaxed);
  cursor_ = mesh->revision;
  return mesh;
}

WatchItem Subscription::Work() {
  if (!cursor_.has_value()) return Snapshot(0);
  const auto diffs = hub_->store_->DiffsFrom(*cursor_);
  if (!diffs.has_value() || diffs->empty()) return Snapshot(*cursor_);
  std::size_t bytes = 0;
  for (const auto& diff : *diffs) bytes += ByteSize(*diff);
  const auto base = hub_->store_->base();
  if (base->revision > *cursor_ && bytes > ByteSize(*base)) return Snapshot(*cursor_);
  auto diff =
      diffs->size() == 1 ? diffs->front() : std::make_shared<const MeshDiff>(Compose(*diffs));
  if (diffs->size() > 1) hub_->coalesced_.fetch_add(1, std::memory_order_relaxed);
  cursor_ = diff->to_revision;
  return diff;
}

bool Subscription::Cancel() {
  const MutexLock lock(hub_->mutex_);
  if (cancelled_) return false;
  cancelled_ = true;
  --hub_->size_;
  return hub_->idle_.erase(shared_from_this()) > 0;
}

}  // namespace dynmesh::server
