// The watchers of a mesh, and the next item of each.
//
// A watcher is a cursor into the mesh's RevisionStore, without a queue of its own. The writer does
// O(1) for all of them, and an idle watcher costs only its cursor. Possible faults of a watch, and
// what rules them out:
//   a revision is lost or sent twice   a cursor advances only by returned items
//   lost wake-up                       a watcher becomes idle under the hub's lock, after it
//                                      looked for news under it; Notify takes that lock
//   older state                        a snapshot is sent to a watcher only if it is newer
//                                      than what the watcher has
//   a future or compacted start        Subscribe refuses it
//   a watcher falls behind             coalesced diffs, or a new snapshot if the diffs
//                                      outweigh the mesh or are no longer held
// Thread-safe, but only one thread at a time drives a Subscription.
#ifndef DYNMESH_SERVER_MESHES_WATCH_HUB_H_
#define DYNMESH_SERVER_MESHES_WATCH_HUB_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <variant>

#include "absl/container/flat_hash_set.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "dynmesh/mesh.h"
#include "server/base/worker_pool.h"
#include "server/revisions/revision_store.h"

namespace dynmesh::server {

class WatchHub;

// What a client can do that is refused because of its start.
inline constexpr char kWatchWithout[] = "watch without start_revision";

// The next item to send: a whole mesh, a diff, a progress message (nothing new), or the end.
using WatchItem =
    std::variant<std::shared_ptr<const Mesh>, std::shared_ptr<const MeshDiff>, Head, absl::Status>;

class Subscription;

class WatchHub : public std::enable_shared_from_this<WatchHub> {
 public:
  struct Options {
    std::uint64_t queue = 64;  // revisions that a watcher may lag
    absl::Duration progress_interval = absl::Seconds(10);
  };
  struct Start {
    std::optional<std::uint64_t> revision = {};  // none: begin with a snapshot
    std::optional<MeshHash> hash = {};           // the watcher's hash at that revision
    absl::Duration progress_interval = {};       // zero: the default
  };

  // Wakes watchers on `pool`, which outlives the hub.
  static std::shared_ptr<WatchHub> Create(std::shared_ptr<RevisionStore> store, WorkerPool* pool,
                                          Options options);

  // The subscription is neither idle nor driven at first: call Next. OUT_OF_RANGE with reason
  // COMPACTED, FUTURE_REVISION or DIVERGED; after Close, its status.
  absl::StatusOr<std::shared_ptr<Subscription>> Subscribe(const Start& start,
                                                          std::function<void()> wake);

  // To be called when the store has a new revision.
  void Notify();
  // Sends progress to watchers that have been idle for their interval. `now` must not decrease.
  void Tick(absl::Time now);
  // Ends all watches with `status` and refuses new ones.
  void Close(absl::Status status);

  std::size_t size() const;
  // Number of watchers that are up to date.
  std::size_t idle() const;

  struct Counts {
    std::size_t behind = 0;       // watchers that are not idle
    std::uint64_t coalesced = 0;  // returned diffs that cover several revisions
    std::uint64_t resynced = 0;   // returned snapshots of watchers that already had one
  };
  Counts counts() const;

 private:
  friend class Subscription;
  using Subscriptions = absl::flat_hash_set<std::shared_ptr<Subscription>>;

  WatchHub(std::shared_ptr<RevisionStore> store, WorkerPool* pool, Options options)
      : store_(std::move(store)), pool_(pool), options_(options) {}
  absl::Status CheckStart(const Start& start) const;
  void Wake(Subscriptions subscriptions);

  const std::shared_ptr<RevisionStore> store_;
  WorkerPool* const pool_;
  const Options options_;
  mutable Mutex mutex_;
  Subscriptions idle_ ABSL_GUARDED_BY(mutex_);
  std::size_t size_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Time now_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  absl::Status closed_ ABSL_GUARDED_BY(mutex_);
  std::atomic<std::uint64_t> coalesced_{0};
  std::atomic<std::uint64_t> resynced_{0};
};

class Subscription : public std::enable_shared_from_this<Subscription> {
 public:
  enum class Step {
    kItem,  // `item` is set: send it, then call Next again
    kIdle,  // nothing now; `wake` will be called once, then call Next again
    kWork,  // call Work on a thread that may block, send its result
  };

  // Quick. After kIdle another thread may call `wake` before this returns.
  Step Next(WatchItem* item);

  // The item for a new or lagging watcher; up to O(mesh).
  WatchItem Work();

  // Ends the subscription. True if it was idle: then `wake` is not called any more, and the caller
  // has to end the stream.
  bool Cancel();

 private:
  friend class WatchHub;
  Subscription(std::shared_ptr<WatchHub> hub, std::function<void()> wake)
      : hub_(std::move(hub)), wake_(std::move(wake)) {}

  WatchItem Snapshot(std::uint64_t newer_than);

  const std::shared_ptr<WatchHub> hub_;
  const std::function<void()> wake_;
  // Used only by the thread that drives the subscription.
  std::optional<std::uint64_t> cursor_;  // the watcher's revision; none at first
  std::uint64_t replay_until_ = 0;       // past revisions were requested up to this one
  bool cancelled_ ABSL_GUARDED_BY(hub_->mutex_) = false;
  bool progress_due_ ABSL_GUARDED_BY(hub_->mutex_) = false;
  absl::Duration progress_interval_ ABSL_GUARDED_BY(hub_->mutex_);
  absl::Time idle_since_ ABSL_GUARDED_BY(hub_->mutex_);
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_WATCH_HUB_H_
