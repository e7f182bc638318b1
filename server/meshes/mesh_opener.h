// Opens the meshes of a shared journal that this node does not have in memory: it claims those that
// are free and loads them, and names the owner of the others.
//
// A mesh is looked up and loaded once at a time, however many calls wait for it, each until its
// deadline. An owner that has missed a renewal is waited for: either it renews, or the mesh is
// claimed when its lease ends. A free mesh is claimed by the node that placement chooses, so a call
// that can go there is sent there, if it has to wait, before it waits; but not more than twice, as
// nodes may differ about which are live. If there are nodes that follow the mesh, placement chooses
// one of them, and the others let them claim it: they look again some times before they claim.
//
// The journal blocks, so the work has a few threads of its own. If it cannot be asked, that answers
// all calls that wait for one of them. Thread-safe.
#ifndef DYNMESH_SERVER_MESHES_MESH_OPENER_H_
#define DYNMESH_SERVER_MESHES_MESH_OPENER_H_

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "server/base/mesh_name.h"
#include "server/base/worker_pool.h"
#include "server/journal/shared_journal.h"
#include "server/meshes/mesh_host.h"

namespace dynmesh::server {

// What a call tells about itself that asks for a mesh.
struct Asking {
  static constexpr int kFollowsNone = -1;

  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  // How often the client was sent to another server with this call; kFollowsNone: it does not go.
  int redirects = kFollowsNone;
};

class MeshOpener {
 public:
  using HostPtr = std::shared_ptr<MeshHost>;
  using Done = std::function<void(absl::StatusOr<HostPtr>)>;
  // Claims the mesh and makes it; called by one thread at a time for one mesh. ABORTED if another
  // node claimed it first, UNAVAILABLE if the journal cannot be read now: then it is tried again.
  using Load = std::function<absl::StatusOr<HostPtr>(const Journal::Mesh& mesh)>;

  // `address`: this node's. The journal outlives the opener.
  MeshOpener(SharedJournal* journal, std::string address, Load load);
  // As Stop.
  ~MeshOpener() { Stop(); }

  // `done` is called once, by a thread of the opener or this one: NOT_FOUND (MESH_NOT_FOUND),
  // UNAVAILABLE (NOT_OWNER; JOURNAL_FAILED), DEADLINE_EXCEEDED, or an error of `load`.
  void Open(const std::string& id, const Asking& asking, Done done);

  // Answers all that wait, and all that come, with `status`. Loads under way go on.
  void Close(const absl::Status& status);
  // Closes, and waits for the loads under way.
  void Stop();

 private:
  using Clock = std::chrono::steady_clock;
  struct Waiter {
    Asking asking;
    Done done;
  };
  struct Opening {
    std::vector<Waiter> waiters;
    bool running = false;    // a step is queued or runs
    bool queued = false;     // it has not begun
    Clock::time_point next;  // of the next step, if none runs
    bool waited = false;     // for the end of the lease: it is this node that claims
    int lost = 0;            // claims that another node was granted
    int left = 0;            // times that it was left to a node that follows
  };
  // What a step has found.
  struct Found {
    absl::StatusOr<HostPtr> answer = HostPtr();
    bool only_followers = false;  // the answer is for those that may be sent elsewhere
    Clock::duration again{0};     // > 0: no answer yet; look again after this time
    bool is_left = false;         // to a node that follows
    absl::Status failure{};       // the journal could not be asked: so it is for other meshes
  };

  void Queue(const std::string& id, Opening& opening) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Step(const std::string& id);
  // Takes all waiters out, with their meshes; `queued_only`: of those whose step has not begun.
  std::vector<std::pair<std::string, Waiter>> TakeAll(bool queued_only)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Found Look(const std::string& id, bool claims, const Opening& before);
  Found LookAt(const std::string& id, const SharedJournal::Located& located, bool claims, int left);
  // Where a mesh is to be opened that its last owner does not have any more; this node's address if
  // that is not known.
  std::string Chosen(const std::string& id, const SharedJournal::Located& located) const;
  // Takes the waiters out that `is_meant` is true for. With the mutex.
  static std::vector<Waiter> Take(Opening& opening,
                                  const std::function<bool(const Waiter&)>& is_meant);
  void RunTimer();

  SharedJournal* const journal_;
  const std::string address_;
  const Load load_;

  Mutex mutex_;
  CondVar changed_;
  std::map<std::string, Opening> openings_ ABSL_GUARDED_BY(mutex_);
  absl::Status closed_ ABSL_GUARDED_BY(mutex_);
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  WorkerPool pool_;
  std::thread timer_;  // last: it uses the others
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_MESH_OPENER_H_
