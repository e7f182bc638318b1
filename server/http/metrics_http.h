// Metrics and health over HTTP: GET /metrics, /healthz, /readyz, and nothing else.
//
// /healthz is 200 as long as the process answers. /readyz is 200 from the end of recovery to the
// drain. It stays 200 while the journal fails, which its text says: reads and watches continue
// then, and the next edit retries the journal.
//
// Its load is bounded, and connections that say nothing delay no others (http_listener.h). Request
// bodies are not read. Thread-safe.
#ifndef DYNMESH_SERVER_HTTP_METRICS_HTTP_H_
#define DYNMESH_SERVER_HTTP_METRICS_HTTP_H_

#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace dynmesh::server {

class MetricsHttp {
 public:
  // Called on its threads, also concurrently.
  struct Sources {
    std::function<std::string()> metrics;
    // Why the server should get no requests now; empty if it is ready.
    std::function<std::string()> not_ready;
    // Faults that do not make it unready, as text; empty if there are none.
    std::function<std::string()> amiss;
  };

  // Returns when it listens. `listen`: HOST:PORT. Without HOST: loopback; port 0 picks a free one.
  // INVALID_ARGUMENT for a malformed address, UNAVAILABLE if it cannot be bound.
  static absl::StatusOr<std::unique_ptr<MetricsHttp>> Listen(const std::string& listen,
                                                             Sources sources);
  // Cuts off running requests.
  ~MetricsHttp();

  const std::string& address() const;  // host:port with the chosen port

 private:
  struct Impl;
  explicit MetricsHttp(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_HTTP_METRICS_HTTP_H_
