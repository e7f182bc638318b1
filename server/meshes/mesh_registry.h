// The meshes of a server, by id. With a journal, a mesh exists iff the journal has it. A mesh that
// cannot be recovered is listed as damaged: calls get the reason, and it can be deleted. A mesh
// that lacks acknowledged revisions is read only, with the reason.
//
// Several servers may share a journal (Join). Then only a part of its meshes is here; the others
// are opened when a call asks for them, or are another server's. Of these some are followed.
// Thread-safe.
#ifndef DYNMESH_SERVER_MESHES_MESH_REGISTRY_H_
#define DYNMESH_SERVER_MESHES_MESH_REGISTRY_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/base/mutex.h"
#include "proto/codec/journal_codec.h"
#include "server/base/mesh_name.h"
#include "server/config/config.h"
#include "server/journal/journal.h"
#include "server/journal/shared_journal.h"
#include "server/meshes/followers.h"
#include "server/meshes/mesh_host.h"
#include "server/meshes/mesh_opener.h"
#include "server/metrics/server_metrics.h"

namespace dynmesh::server {

class RecoveryProgress;
struct RecoveredMesh;

class MeshRegistry {
 public:
  using HostPtr = std::shared_ptr<MeshHost>;

  // The pools, the journal, the metrics and the guard outlive the registry. Without a journal
  // nothing outlives the registry; without metrics nothing is counted.
  MeshRegistry(const ServerConfig& config, MeshFactory factory, WorkerPool* writers,
               WorkerPool* readers, Journal* journal = nullptr, ServerMetrics* metrics = nullptr,
               const MemoryGuard* memory = nullptr);
  // As CloseAll.
  ~MeshRegistry();

  // Recovers the journal's meshes, several at a time. Before any other call.
  absl::Status Recover();
  // In place of Recover, for a journal that several servers share: tells them that this one is at
  // `address`, and begins to open the free meshes that placement gives it. `reads` says whether a
  // read that was made may be answered, as LeaseKeeper::MayAnswerReads.
  absl::Status Join(const std::string& address, std::function<bool()> reads);
  // Renews the leases of the journal's meshes, and drops those that another server has. After Join.
  absl::Status Renew();

  // The caller, for the log.
  struct Origin {
    std::string client;  // Pass::client
    std::string call;    // CallIdOf
  };

  // Makes a mesh; with an empty `id` the registry chooses the id. ALREADY_EXISTS (MESH_EXISTS),
  // unless the mesh was made with the same non-empty `request_id` and `options`: then returns it.
  // RESOURCE_EXHAUSTED (MESH_LIMIT; MEMORY_LIMIT, VERTEX_LIMIT or WORK_LIMIT: with max_edge even an
  // empty mesh costs work). CANCELLED if `cancelled`, which may be null, turned true. Blocks while
  // an empty mesh is made and written.
  absl::StatusOr<HostPtr> Create(const std::string& id, const MeshOptions& options,
                                 const std::string& request_id,
                                 const std::atomic<bool>* cancelled = nullptr,
                                 const Origin& origin = {});

  // Calls `done` with `created`, the result of Create. If another server may have made the mesh
  // with this request_id, it is opened first.
  void FindMade(const absl::StatusOr<HostPtr>& created, const MeshOptions& options,
                const std::string& request_id, const Asking& asking, MeshOpener::Done done);

  // The largest max_vertices for a mesh of that dimension.
  std::uint64_t MaxVertices(int dimension) const;

  // NOT_FOUND (MESH_NOT_FOUND); INVALID_ARGUMENT for a malformed name; DATA_LOSS (MESH_DAMAGED);
  // UNAVAILABLE (NOT_OWNER) for a mesh that another server has.
  absl::StatusOr<HostPtr> Find(absl::string_view name) const;
  // The same for a mesh that may not be here yet: `done` is called once, with what Find returns, at
  // once or by another thread; also with UNAVAILABLE (JOURNAL_FAILED) and DEADLINE_EXCEEDED.
  void Open(absl::string_view name, const Asking& asking, MeshOpener::Done done);
  // The same for a read of a state that is at least `min_revision`: also with a host that follows
  // the mesh. Without `min_revision` as Open. OUT_OF_RANGE (FUTURE_REVISION) if the mesh is not
  // there yet.
  void OpenToRead(absl::string_view name, const Asking& asking,
                  std::optional<std::uint64_t> min_revision, MeshOpener::Done done);
  // OK if a state of the mesh that has been read may be answered as the present one; UNAVAILABLE
  // (NOT_OWNER) if another server may have changed it meanwhile.
  absl::Status CheckRead(absl::string_view id) const;
  // The diffs of a mesh here from `start`, which has a revision, on to the present one, made again
  // from the journal; at least one. `done` is called once, by this thread or one for such work,
  // which makes one past at a time. OUT_OF_RANGE: DIVERGED; without a reason if the journal does
  // not go back as far, if they are more than the mesh itself would hold, or if they take too long.
  // CANCELLED soon after `cancelled` turned true; RESOURCE_EXHAUSTED if too many wait.
  using Past = std::vector<RevisionStore::DiffPtr>;
  void MakePast(const HostPtr& host, const WatchHub::Start& start,
                std::shared_ptr<const std::atomic<bool>> cancelled,
                std::function<void(absl::StatusOr<Past>)> done);
  // Waits for the journal. The journal frees the mesh's bytes later.
  absl::Status Delete(absl::string_view name, const Origin& origin = {});

  struct Listed {
    std::string id;
    HostPtr host;         // null: not readable
    absl::Status damage;  // the reason; with a host: why it is read only
    // Of a mesh that is not here, but is not damaged either:
    std::string owner;  // the address of its server, or "none"
    std::uint64_t revision = 0;
    absl::Time create_time;
  };
  // At most `limit` meshes with ids > `after`, sorted by id. If `shown` is given, only ids for
  // which it returns true.
  std::vector<Listed> List(absl::string_view after, std::size_t limit,
                           const std::function<bool(absl::string_view)>& shown = nullptr) const;
  // True after Join: then ListAll has all meshes of the journal, as List those that are here. Waits
  // for the journal. UNAVAILABLE (JOURNAL_FAILED).
  bool is_shared() const { return shared_ != nullptr; }
  absl::StatusOr<std::vector<Listed>> ListAll(
      absl::string_view after, std::size_t limit,
      const std::function<bool(absl::string_view)>& shown) const;
  // All meshes that are not damaged, by id.
  std::vector<HostPtr> Hosts() const;

  std::size_t size() const;
  std::size_t damaged() const;  // of these
  // Blocks until no snapshot for the journal is being made or waits. For tests.
  void WaitForSnapshots() {
    if (snapshots_ != nullptr) snapshots_->Wait();
  }
  std::size_t watchers() const;
  void Tick(absl::Time now);
  // Stops the removal of deleted meshes' rows from the journal. The next start continues it.
  void EndSweeps() { *sweeps_ended_ = true; }
  // Ends all watches and refuses all waiting jobs with `status`.
  void CloseAll(const absl::Status& status);
  void CloseWatches(const absl::Status& status);
  // Before a drain: hands the meshes over to the servers that follow them, each when what was
  // applied is written. Waits at most for `limit`. What is not handed over stays.
  void HandOver(absl::Duration limit);
  // The meshes that this server follows.
  std::vector<Followers::Followed> Followed() const;
  // Answers all calls that wait for a mesh to be opened, now and later, with `status`.
  void CloseOpening(const absl::Status& status);
  // Of a mesh here: the epoch in which this server has it; 0 if servers do not share the journal.
  std::int64_t EpochOf(const std::string& id) const;

 private:
  struct Kept {
    HostPtr host;         // null: not readable
    absl::Status damage;  // the reason; with a host: why it is read only
    Journal::Key key = 0;
    std::string request_id;  // of its creation, if any
  };

  MeshHost::Options HostOptions() const;
  absl::StatusOr<HostPtr> FindCreated(const std::string& id, const MeshOptions& options,
                                      const std::string& request_id) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status CheckRoom(const std::string& id) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<Past> PastOf(const MeshHost& host, const WatchHub::Start& start,
                              const std::atomic<bool>& cancelled) const;
  static absl::Status DamageOf(absl::string_view id, const absl::Status& status);
  std::string FreshId(const std::string& request_id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void RecoverOne(const Journal::Mesh& mesh, RecoveryProgress& progress);
  absl::StatusOr<RecoveredMesh> ReadAtStart(const Journal::Mesh& mesh, absl::Time start,
                                            RecoveryProgress& progress);
  // Of a shared journal.
  absl::StatusOr<HostPtr> LoadShared(const Journal::Mesh& mesh);
  absl::Status OpenChosen();
  void StartFollowers();
  absl::StatusOr<HostPtr> MakeFollower(const Journal::Mesh& mesh) const;
  // Puts a mesh in that was followed until it was taken over.
  void PutFollowed(const Journal::Mesh& mesh, const HostPtr& host, absl::Time start);
  // Of a mesh that is to be deleted and is not here: NOT_FOUND, or NOT_OWNER if it is leased.
  absl::StatusOr<Journal::Key> KeyElsewhere(const std::string& id) const;
  Listed ListedOf(const SharedJournal::Located& located) const;
  // Drops a mesh that another server has. The host is destroyed by a writer.
  void Drop(const std::string& id, const HostPtr& host, const absl::Status& why);
  // Makes the host of a recovered mesh, and puts it in.
  HostPtr Put(const Journal::Mesh& mesh, RecoveredMesh found, absl::Time start);
  absl::StatusOr<std::unique_ptr<DynamicMesh>> Make(const MeshOptions& options,
                                                    const std::atomic<bool>* cancelled) const;
  absl::StatusOr<Journal::Key> WriteDown(const std::string& id, const codec::JournalMesh& mesh);

  const ServerConfig config_;
  const MeshFactory factory_;
  WorkerPool* const writers_;
  WorkerPool* const readers_;
  Journal* const journal_;
  ServerMetrics* const metrics_;
  const MemoryGuard* const memory_;

  // Held while a mesh is made or deleted, which includes disk writes.
  Mutex changing_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);
  mutable Mutex mutex_;
  std::map<std::string, Kept, std::less<>> hosts_ ABSL_GUARDED_BY(mutex_);
  // The mesh made with a request_id, for Create without an id. Create with an id looks at that mesh
  // only: the caller may lack the rights to know of others.
  std::map<std::string, std::string> made_ ABSL_GUARDED_BY(mutex_);
  const std::shared_ptr<std::atomic<bool>> sweeps_ended_ =
      std::make_shared<std::atomic<bool>>(false);
  std::mt19937_64 random_ ABSL_GUARDED_BY(mutex_){std::random_device{}()};

  std::atomic<int> pasts_{0};  // wait or are made
  std::atomic<bool> ends_{false};
  // Null without a journal. Hosts share it, and may outlive the registry.
  const std::shared_ptr<Snapshots> snapshots_;
  WorkerPool past_pool_{1, WorkerPool::Priority::kBackground};

  // Set by Join.
  SharedJournal* shared_ = nullptr;
  std::string address_;
  std::function<bool()> reads_;
  std::unique_ptr<Followers> followers_;
  std::unique_ptr<MeshOpener> opener_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_MESH_REGISTRY_H_
