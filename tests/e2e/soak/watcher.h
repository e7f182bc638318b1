// A watcher of a soak's mesh, of one of three kinds: steady; slow, with pauses between the events,
// so that the server has to coalesce; or restless, disconnecting at random and resuming at its
// revision. None may miss a revision or see one twice, and in the end all must have the last one,
// with its hash.
#ifndef DYNMESH_TESTS_E2E_SOAK_WATCHER_H_
#define DYNMESH_TESTS_E2E_SOAK_WATCHER_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <string>

#include "absl/synchronization/notification.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/client/mesh_replica.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "tests/e2e/soak/ledger.h"
#include "tests/e2e/soak/revision_check.h"

namespace dynmesh::soak {

// Of all watchers together.
struct WatchCounts {
  std::atomic<std::uint64_t> revisions = 0;   // that came one by one
  std::atomic<std::uint64_t> coalesced = 0;   // diffs of several
  std::atomic<std::uint64_t> resyncs = 0;     // snapshots in the place of diffs
  std::atomic<std::uint64_t> reconnects = 0;  // planned, resumed by revision
  std::atomic<std::uint64_t> compacted = 0;   // the revision to resume from was no longer held
  std::atomic<std::uint64_t> broken = 0;      // streams that ended by themselves
  std::atomic<std::uint64_t> lost = 0, doubled = 0, damaged = 0;
};

// Reads the stream itself. Run belongs to one thread, all else to any.
class Watcher {
 public:
  enum class Manner { kSteady, kSlow, kRestless };
  struct Config {
    std::string mesh;
    Manner manner = Manner::kSteady;
    bool replica = false;  // holds the mesh, else counts revisions only
    absl::Duration nap;    // of a slow one between events; of a restless one between streams
    std::uint64_t seed = 0;
  };
  Watcher(const Config& config, std::shared_ptr<grpc::Channel> channel, WatchCounts* counts,
          Faults* faults);

  // Until it has the revision given to Close, or Abandon.
  void Run();

  // No revision will follow this one, and no watcher sleeps any more.
  void Close(std::uint64_t last_revision);
  void Abandon();

  const Config& config() const { return config_; }
  std::uint64_t revision() const { return revision_; }
  // After Run: whether it has the last revision, with that hash.
  bool Has(std::uint64_t last_revision, const std::string& hash) const;

 private:
  bool Done() const { return abandoned_ || (closing_.HasBeenNotified() && revision_ >= last_); }
  void FollowOnce();
  // False if the stream is to be closed.
  bool Take(const v1::WatchEvent& event);
  void Ended(const absl::Status& status, bool planned);
  void Blame(const absl::Status& status);
  void Nap(absl::Duration mean);
  v1::WatchRequest Request() const;

  const Config config_;
  const std::unique_ptr<v1::MeshService::Stub> stub_;
  WatchCounts* const counts_;
  Faults* const faults_;
  std::mt19937_64 random_;
  RevisionCheck check_;
  std::optional<client::MeshReplica> replica_;
  bool blamed_ = false;  // the stream that is open went wrong
  std::atomic<std::uint64_t> revision_ = 0;
  std::atomic<std::uint64_t> last_ = 0;
  std::atomic<bool> abandoned_ = false;
  absl::Notification closing_;
  std::mutex mutex_;
  grpc::ClientContext* context_ = nullptr;  // of the stream that is open
};

// A steady one with a mesh, as the client library's WatchSession does it.
class SessionWatcher final : public client::WatchListener {
 public:
  SessionWatcher(std::string mesh, client::MeshClient& client, WatchCounts* counts, Faults* faults);

  std::uint64_t revision() const { return revision_; }
  const std::string& mesh() const { return mesh_; }
  bool WaitFor(std::uint64_t last_revision, const MeshHash& hash, absl::Duration limit);
  void Stop() { session_->Stop(); }

 private:
  void OnSnapshot(const client::MeshReplica& replica) override;
  void OnDiff(const client::MeshReplica& replica, const MeshDiff& diff) override;
  void OnTrouble(const absl::Status& status) override;
  void OnEnd(const absl::Status& status) override;

  const std::string mesh_;
  WatchCounts* const counts_;
  Faults* const faults_;
  bool began_ = false;
  std::atomic<std::uint64_t> revision_ = 0;
  std::unique_ptr<client::WatchSession> session_;  // the last: its callbacks use the others
};

}  // namespace dynmesh::soak

#endif  // DYNMESH_TESTS_E2E_SOAK_WATCHER_H_
