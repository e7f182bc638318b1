// Who watches a mesh, and what each gets next.
//
// A watcher is a cursor into the mesh's RevisionStore, not a queue of its own: the
// writer does O(1) for all of them, and a thousand watchers that stand still cost no
// memory but their cursors. What can go wrong with watches, and what rules it out:
//   a revision is lost or sent twice   a cursor moves by what was handed out only
//   lost wake-up                       a watcher turns idle under the hub's lock, after
//                                      looking for news under it; Notify takes that lock
//   time travel                        a snapshot replaces what a watcher has only if it
//                                      is newer
//   a future or compacted start        Subscribe refuses it
//   a watcher falls behind             coalesced diffs or, when they would outweigh the
//                                      mesh or are no longer held, a new snapshot
// Thread-safe, but one Subscription is driven by one thread at a time.
#ifndef DYNMESH_SERVER_MESHES_WATCH_HUB_H_
#define DYNMESH_SERVER_MESHES_WATCH_HUB_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <variant>

#include "absl/container/flat_hash_set.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "dynmesh/mesh.h"
#include "server/base/worker_pool.h"
#include "server/revisions/revision_store.h"

namespace dynmesh::server {

class WatchHub;

// The next thing to send: a whole mesh, a diff, "nothing new", or the end.
using WatchItem =
    std::variant<std::shared_ptr<const Mesh>, std::shared_ptr<const MeshDiff>, Head, absl::Status>;

class Subscription : public std::enable_shared_from_this<Subscription> {
 public:
  enum class Step {
    kItem,  // `item` is set: send it, then call Next again
    kIdle,  // nothing now; `wake` will be called once, then call Next again
    kWork,  // call Work on a thread that may take a while, send what it returns
  };

  // Quick. After kIdle another thread may call `wake` before this returns.
  Step Next(WatchItem* item);

  // What a watcher that lags or begins gets; O(mesh) at worst.
  WatchItem Work();

  // Ends the subscription. True if it was idle, that is if `wake` will not be called
  // any more and the caller is to end the stream.
  bool Cancel();

 private:
  friend class WatchHub;
  Subscription(std::shared_ptr<WatchHub> hub, std::function<void()> wake)
      : hub_(std::move(hub)), wake_(std::move(wake)) {}

  WatchItem Snapshot(std::uint64_t newer_than);

  const std::shared_ptr<WatchHub> hub_;
  const std::function<void()> wake_;
  // Belong to the thread that drives the subscription.
  std::optional<std::uint64_t> cursor_;  // the revision the watcher has; none at first
  std::uint64_t replay_until_ = 0;       // it asked for the revisions up to here
  // Guarded by the hub's mutex.
  bool cancelled_ = false;
  bool progress_due_ = false;
  absl::Duration progress_interval_;
  absl::Time idle_since_;
};

class WatchHub : public std::enable_shared_from_this<WatchHub> {
 public:
  struct Options {
    std::uint64_t queue = 64;  // revisions a watcher may lag
    absl::Duration progress_interval = absl::Seconds(10);
  };
  struct Start {
    std::optional<std::uint64_t> revision = {};  // none: a snapshot first
    std::optional<MeshHash> hash = {};           // the watcher's at that revision
    absl::Duration progress_interval = {};       // zero: the default
  };

  // Wakes watchers on `pool`, which outlives the hub.
  static std::shared_ptr<WatchHub> Create(std::shared_ptr<RevisionStore> store, WorkerPool* pool,
                                          Options options);

  // Neither idle nor driven at first: call Next. OUT_OF_RANGE with reason COMPACTED,
  // FUTURE_REVISION or DIVERGED; after Close, its status.
  absl::StatusOr<std::shared_ptr<Subscription>> Subscribe(const Start& start,
                                                          std::function<void()> wake);

  // The store has a new revision.
  void Notify();
  // Tells the hub the time: progress for those idle too long. Times must not fall.
  void Tick(absl::Time now);
  // Ends all watches with `status` and refuses new ones.
  void Close(absl::Status status);

  std::size_t size() const;
  // Watchers that have all there is.
  std::size_t idle() const;

  struct Counts {
    std::size_t behind = 0;       // watchers that are not idle
    std::uint64_t coalesced = 0;  // diffs handed out that stand for several revisions
    std::uint64_t resynced = 0;   // snapshots handed out to watchers that had one
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
  mutable std::mutex mutex_;
  Subscriptions idle_;
  std::size_t size_ = 0;
  absl::Time now_ = absl::InfinitePast();
  absl::Status closed_;
  std::atomic<std::uint64_t> coalesced_{0};
  std::atomic<std::uint64_t> resynced_{0};
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_WATCH_HUB_H_
