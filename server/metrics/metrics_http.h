// Metrics and health over HTTP: GET /metrics, /healthz, /readyz, and nothing else.
//
// /healthz is 200 as long as the process answers. /readyz is 200 from the end of recovery to the
// drain: also while the journal fails, which its text says. Reads and watches go on then, and it is
// the next edit that finds out whether the journal can be written again.
//
// It cannot hurt the server: two threads, a few connections that wait for them, and of each
// connection one request of a few kilobytes in a few seconds, whatever the other side does.
// Requests with a body are answered without reading it. Thread-safe.
#ifndef DYNMESH_SERVER_METRICS_METRICS_HTTP_H_
#define DYNMESH_SERVER_METRICS_METRICS_HTTP_H_

#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace dynmesh::server {

class MetricsHttp {
 public:
  // Called on its threads, also at the same time.
  struct Sources {
    std::function<std::string()> metrics;
    // Why the server should get no requests now; empty if it should.
    std::function<std::string()> not_ready;
    // What is amiss though it is ready, for people; empty if nothing is.
    std::function<std::string()> amiss;
  };

  // Listens when it returns. `listen`: HOST:PORT, of which HOST may be missing and is loopback
  // then; port 0 takes a free one. INVALID_ARGUMENT for what is no address, UNAVAILABLE if it
  // cannot be had.
  static absl::StatusOr<std::unique_ptr<MetricsHttp>> Listen(const std::string& listen,
                                                             Sources sources);
  // What is under way is cut off.
  ~MetricsHttp();

  const std::string& address() const;  // host:port with the port chosen

 private:
  struct Impl;
  explicit MetricsHttp(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_METRICS_METRICS_HTTP_H_
