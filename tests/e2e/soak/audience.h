// All watchers of a soak: their kinds, how far behind they are, and whether all reached the end.
//
// Belongs to one thread; the watchers have their own.
#ifndef DYNMESH_TESTS_E2E_SOAK_AUDIENCE_H_
#define DYNMESH_TESTS_E2E_SOAK_AUDIENCE_H_

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "dynmesh/client/mesh_client.h"
#include "dynmesh/mesh.h"
#include "tests/e2e/soak/ledger.h"
#include "tests/e2e/soak/watcher.h"

namespace dynmesh::soak {

// Where a mesh is.
struct MeshHead {
  std::uint64_t revision = 0;
  MeshHash hash = {};
};

class Audience {
 public:
  struct Plan {
    int watchers = 100;  // all together, evenly over the meshes
    int slow = 20;
    int restless = 20;
    int sessions = 12;  // with a mesh in a WatchSession
    double nap_seconds = 1;
    std::uint64_t seed = 1;
  };
  // Plain values, to be sent from process to process.
  struct Report {
    double lag_steady_max = 0, lag_slow_p50 = 0, lag_slow_max = 0;  // revisions
    std::uint64_t revisions = 0, coalesced = 0, resyncs = 0, reconnects = 0, compacted = 0;
    std::uint64_t broken = 0, lost = 0, doubled = 0, damaged = 0;
    std::uint64_t watchers = 0, at_end = 0;  // after Close: at the end, with its hash
    std::uint64_t faults = 0;
  };
  Audience(const Plan& plan, std::vector<std::string> meshes, Faults* faults);
  ~Audience();

  // On a few channels of TLS; sessions go through `client`.
  void Start(const std::string& address, const std::string& authority, client::MeshClient& client);

  // No more edits follow, and these are the ends: waits until all watchers have reached them, and
  // ends them.
  void Close(std::span<const MeshHead> heads, double seconds);

  // `heads`: the last revision of each mesh that a writer was notified of.
  Report ReportOf(std::span<const MeshHead> heads) const;

 private:
  std::size_t IndexOf(const std::string& mesh) const;

  const Plan plan_;
  const std::vector<std::string> meshes_;
  Faults* const faults_;
  WatchCounts counts_;
  std::vector<std::shared_ptr<grpc::Channel>> channels_;
  std::vector<std::unique_ptr<Watcher>> watchers_;
  std::vector<std::unique_ptr<SessionWatcher>> sessions_;
  std::vector<std::thread> threads_;
  std::uint64_t at_end_ = 0;
};

}  // namespace dynmesh::soak

#endif  // DYNMESH_TESTS_E2E_SOAK_AUDIENCE_H_
