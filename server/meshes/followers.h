// The meshes of a shared journal that this node follows: another node has them, and this one makes
// each revision again, from the journal. So it can answer reads that need not be of the present
// state, and take the mesh over without reading it.
//
// One thread asks the journal for what came after all of them, with a bounded number of statements,
// every 50 ms, after news sooner. Each mesh applies its entries on its own strand. The hash of each
// revision is compared with the journal's. If one differs, the replica is dropped, counted and
// logged (follower_mismatch). The mesh is then read again from the beginning, once: that tells a
// fault of this process's memory, which is gone then, from a journal that does not fit this
// program, which will differ again. After a second mismatch the mesh is not followed until the
// process starts again. The journal is right: the mesh's owner is not touched.
//
// A mesh is followed because its owner asks for it, or because a read does. Each node asks for
// followers of its own meshes that are *in use*, that is of which a new revision came within the
// idle time: those nodes that placement gives them next. It is not followed any more after the idle
// time without a read, a watch or, if its owner asks for it, a new revision. At most `max_meshes`
// are followed.
//
// The journal knows which nodes follow a mesh: a drain hands it to one of them, free meshes are
// left to them.
//
// A mesh whose lease has ended, or that its owner has handed over, is told to `take_over`. Blocking
// work has threads of its own. Thread-safe.
#ifndef DYNMESH_SERVER_MESHES_FOLLOWERS_H_
#define DYNMESH_SERVER_MESHES_FOLLOWERS_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "server/base/worker_pool.h"
#include "server/journal/shared_journal.h"
#include "server/meshes/mesh_host.h"
#include "server/metrics/server_metrics.h"

namespace dynmesh::server {

class Followers {
 public:
  using HostPtr = std::shared_ptr<MeshHost>;
  using Clock = std::chrono::steady_clock;
  using Done = std::function<void(absl::StatusOr<HostPtr>)>;

  struct Options {
    std::size_t per_mesh = 1;      // nodes that follow a mesh in use, besides its owner; 0: none
    std::size_t max_meshes = 100;  // followed here
    Clock::duration idle = std::chrono::minutes(10);
    Clock::duration poll = std::chrono::milliseconds(50);
    Clock::duration poll_after_news = std::chrono::milliseconds(10);
    Clock::duration ask = std::chrono::seconds(1);  // between exchanges of wishes
  };
  // A mesh of this node.
  struct Owned {
    Journal::Key key = 0;
    std::string id;
    std::uint64_t revision = 0;
  };
  struct Calls {
    // Reads the mesh from the journal, without a claim, and makes its host. UNIMPLEMENTED if the
    // journal has other bits, DATA_LOSS if what it has cannot be made again.
    std::function<absl::StatusOr<HostPtr>(const Journal::Mesh&)> make;
    // The followed mesh is free, or this node's: it may be taken over. `done` is called when that
    // has been tried.
    std::function<void(const std::string& id, std::function<void()> done)> take_over;
    std::function<std::vector<Owned>()> owned;
    // Not OK: nothing more is to be followed now.
    std::function<absl::Status()> check_room;
  };

  // `address`: this node's. The journal and the metrics, which may be null, outlive the followers.
  Followers(SharedJournal* journal, std::string address, const Options& options, Calls calls,
            FollowerMetrics* metrics);
  // As Stop.
  ~Followers() { Stop(); }

  // A host of the mesh that is at `min_revision` or later. `done` is called once, by any thread:
  // with null if no other node has the mesh: it can be claimed; UNAVAILABLE (NOT_OWNER, with the
  // owner) if there is no such host at `end`, or the mesh is not to be followed here; NOT_FOUND;
  // UNAVAILABLE (JOURNAL_FAILED).
  void Read(const std::string& id, std::uint64_t min_revision, Clock::time_point end, Done done);

  // If the mesh is followed, claims it by `claim`, applies what is missing, and gives the host,
  // which is an owner's from then on and not followed any more. Null if it is not followed: it is
  // to be read, and `claim` may have been called. Blocks. Errors of `claim`; UNAVAILABLE.
  absl::StatusOr<HostPtr> TakeOver(const Journal::Mesh& mesh,
                                   const std::function<absl::Status()>& claim);

  // Follows nothing new and takes nothing over from now on; what is followed goes on.
  void Settle();
  // Ends the watches of all followed meshes with `status`.
  void CloseWatches(const absl::Status& status);
  // Closes all hosts, and waits for the work under way.
  void Stop();

  struct Followed {
    HostPtr host;
    std::uint64_t behind = 0;  // revisions that the journal has and the host has not
    double lag_seconds = 0;    // since the host had all that the journal had; 0: it has
  };
  // Those with a host, by id.
  std::vector<Followed> List() const;

 private:
  struct Waiter {
    std::uint64_t min_revision;
    Clock::time_point end;
    Done done;
  };
  struct Follower {
    std::string id;
    Journal::Mesh mesh;  // key 0: not looked up yet
    HostPtr host;        // null: it is being opened
    SharedJournal::Position position;
    bool busy = true;  // opened, applied to or taken over: nothing is read for it
    bool taking = false;
    bool wanted = false;  // by its owner
    std::uint64_t head = 0;
    Clock::time_point caught_up, used;
    MeshOwner owner;
    std::vector<Waiter> waiters;  // for the host
  };
  using FollowerPtr = std::shared_ptr<Follower>;
  // A mesh of this node, as it was seen last.
  struct Seen {
    std::uint64_t revision = 0;
    Clock::time_point changed;
    std::uint64_t look = 0;
  };

  // For callbacks on strands, which may run when the followers are gone.
  struct Life {
    Mutex mutex;
    Followers* it ABSL_GUARDED_BY(mutex);
  };

  void Run();
  // True if there is news.
  bool Poll() ABSL_EXCLUSIVE_LOCKS_REQUIRED(of_thread_);
  bool Judge(const FollowerPtr& follower, const SharedJournal::Tail& tail);
  void EndTaking(const FollowerPtr& follower);
  // Waits for it.
  absl::Status Apply(const HostPtr& host, const SharedJournal::Tail& tail);
  void Applied(const FollowerPtr& follower, const SharedJournal::Position& reached,
               const absl::Status& status);
  void Expire();
  // Asks for followers of this node's meshes.
  void Ask() ABSL_EXCLUSIVE_LOCKS_REQUIRED(of_thread_);
  bool IsInUse(const Owned& mesh) ABSL_EXCLUSIVE_LOCKS_REQUIRED(of_thread_);
  // Follows what this node is asked for.
  void TakeWishes();
  void DropUnused(Clock::time_point now);

  void OpenOne(const FollowerPtr& follower);
  // What a thread does after a mesh that it has made in the time `worked`. Not after Settle.
  void Rest(Clock::duration worked);
  // OK: the mesh is another node's, and may be followed.
  absl::Status LookUp(const FollowerPtr& follower, bool* is_free);
  absl::Status CheckRoomLocked(const Follower& follower) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  FollowerPtr AddLocked(const std::string& id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Ends the follower with `status`, unless it has ended.
  void Drop(const FollowerPtr& follower, const absl::Status& status);
  bool IsThereLocked(const FollowerPtr& follower) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Counts and logs, if the status says that what is here differs from the journal.
  void Distrust(const FollowerPtr& follower, const absl::Status& status);
  void Kick();

  SharedJournal* const journal_;
  const std::string address_;
  const Options options_;
  const Calls calls_;
  FollowerMetrics* const metrics_;

  mutable Mutex mutex_;
  CondVar kicked_, idle_;
  std::map<std::string, FollowerPtr> by_id_ ABSL_GUARDED_BY(mutex_);
  std::map<Journal::Key, int> mismatches_ ABSL_GUARDED_BY(mutex_);
  bool kick_ ABSL_GUARDED_BY(mutex_) = false;
  bool settled_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;

  ThreadRole of_thread_;  // the part of thread_
  std::map<Journal::Key, Seen> seen_ ABSL_GUARDED_BY(of_thread_);
  std::uint64_t looks_ ABSL_GUARDED_BY(of_thread_) = 0;
  bool failing_ ABSL_GUARDED_BY(of_thread_) = false;

  const std::shared_ptr<Life> life_ = std::make_shared<Life>();
  WorkerPool pool_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_FOLLOWERS_H_
