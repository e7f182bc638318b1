// The audience in a process of its own: watchers stand for other machines. Among the writers they
// would share gRPC's one poller, by which any thread that waits reads for all connections of its
// process, so that answers to writers would wait for a watcher's turn on a core.
//
// Belongs to one thread.
#ifndef DYNMESH_TESTS_E2E_SOAK_AUDIENCE_PROCESS_H_
#define DYNMESH_TESTS_E2E_SOAK_AUDIENCE_PROCESS_H_

#include <sys/types.h>

#include <span>
#include <string>
#include <vector>

#include "tests/e2e/soak/audience.h"

namespace dynmesh::soak {

class AudienceProcess {
 public:
  // How much of this machine it gets beside server and writers.
  enum class Share {
    kTenth,  // where there are not cores for all
    kRest,   // what nobody else wants, as if it took no core from them; on a busy machine nothing
  };

  // Makes the process. REQUIRES: this one has no other threads and has not used gRPC.
  AudienceProcess(const Audience::Plan& plan, Share share);
  AudienceProcess(const AudienceProcess&) = delete;
  AudienceProcess& operator=(const AudienceProcess&) = delete;
  ~AudienceProcess();

  void Start(const std::string& address, const std::string& authority,
             const std::vector<std::string>& meshes);

  // As of Audience. If the process is gone, that is a fault.
  Audience::Report ReportOf(std::span<const MeshHead> heads) { return Ask(heads, kGoOn); }
  Audience::Report Close(std::span<const MeshHead> heads, double seconds) {
    return Ask(heads, seconds);
  }
  // Of the last report, the first few in words.
  const std::vector<std::string>& faults() const { return faults_; }

 private:
  static constexpr double kGoOn = -1;  // in the place of seconds to close in

  Audience::Report Ask(std::span<const MeshHead> heads, double close_seconds);
  [[noreturn]] static void Serve(int socket, const Audience::Plan& plan, Share share);

  pid_t child_ = 0;
  int socket_ = -1;
  std::vector<std::string> faults_;
};

}  // namespace dynmesh::soak

#endif  // DYNMESH_TESTS_E2E_SOAK_AUDIENCE_PROCESS_H_
