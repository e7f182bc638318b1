// The audience in a process of its own: watchers stand for other machines. In the writers' process
// they would share gRPC's single poller, with which any waiting thread reads for all connections of
// the process, so that answers to writers would wait for a watcher's turn on a core.
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
  // Its share of this machine beside server and writers.
  enum class Share {
    kTenth,  // if there are not cores for all
    kRest,   // only idle cores, as if on another machine; on a busy machine nothing
  };

  // Makes the process. REQUIRES: this one has no other threads and has not used gRPC.
  AudienceProcess(const Audience::Plan& plan, Share share);
  AudienceProcess(const AudienceProcess&) = delete;
  AudienceProcess& operator=(const AudienceProcess&) = delete;
  ~AudienceProcess();

  void Start(const std::string& address, const std::string& authority,
             const std::vector<std::string>& meshes);

  // As of Audience. It is a fault if the process has ended.
  Audience::Report ReportOf(std::span<const MeshHead> heads) { return Ask(heads, kGoOn); }
  Audience::Report Close(std::span<const MeshHead> heads, double seconds) {
    return Ask(heads, seconds);
  }
  // Of the last report, the first few as text.
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
