// All watchers of a soak: who they are, how far behind they are, and whether all got to the end.
//
// Belongs to one thread; the watchers have their own.
#ifndef DYNMESH_TESTS_E2E_SOAK_AUDIENCE_H_
#define DYNMESH_TESTS_E2E_SOAK_AUDIENCE_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "client/cli/json.h"
#include "client/mesh_client.h"
#include "tests/e2e/soak/ledger.h"
#include "tests/e2e/soak/watcher.h"
#include "tests/e2e/soak/writer.h"

namespace dynmesh::soak {

// A mesh with what is known of it.
struct Site {
  MeshPlan plan;
  Ledger ledger;
  std::uint64_t head = 0;  // at the end, as the server has it
  MeshHash hash;
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
  Audience(const Plan& plan, std::deque<Site>* sites, Faults* faults);
  ~Audience();

  // On a few channels of TLS; sessions go through `client`.
  void Start(const std::string& address, const std::string& authority, client::MeshClient& client);

  // Nobody edits any more, and the sites know their ends: waits until all watchers are there, and
  // ends them.
  void Close(double seconds);

  cli::JsonObject Report() const;
  const WatchCounts& counts() const { return counts_; }
  std::size_t size() const { return watchers_.size() + sessions_.size(); }
  // After Close: who got to the end, with the server's hash.
  std::size_t at_end() const { return at_end_; }

 private:
  const Site& SiteOf(const std::string& mesh) const;
  double Lag(const std::string& mesh, std::uint64_t revision) const;

  const Plan plan_;
  std::deque<Site>* const sites_;
  Faults* const faults_;
  WatchCounts counts_;
  std::vector<std::shared_ptr<grpc::Channel>> channels_;
  std::vector<std::unique_ptr<Watcher>> watchers_;
  std::vector<std::unique_ptr<SessionWatcher>> sessions_;
  std::vector<std::thread> threads_;
  std::size_t at_end_ = 0;
};

}  // namespace dynmesh::soak

#endif  // DYNMESH_TESTS_E2E_SOAK_AUDIENCE_H_
