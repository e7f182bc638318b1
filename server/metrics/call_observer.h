// Sees every call of the gRPC server, as an interceptor: counts it, times it, gives it an id
// (call_id.h), and tells it if it fails. The names are those that Prometheus' middleware for gRPC
// uses elsewhere. Methods that are not ours (reflection, what does not exist) are one, "other".
// Thread-safe; a few atomic operations a message.
#ifndef DYNMESH_SERVER_METRICS_CALL_OBSERVER_H_
#define DYNMESH_SERVER_METRICS_CALL_OBSERVER_H_

#include <grpcpp/support/server_interceptor.h>

#include <memory>

#include "server/base/work_gate.h"
#include "server/metrics/failed_calls.h"
#include "server/metrics/metrics.h"

namespace dynmesh::server {

class CallMetrics {
 public:
  explicit CallMetrics(MetricRegistry& registry);
  ~CallMetrics();

  struct Method;
  Method& Find(const char* path) const;  // "/package.Service/Method"
  FailedCalls& failed() const;
  // The calls of the service that are open, until their last byte is with the transport. Closed,
  // it counts no new ones.
  WorkGate& open() const;

 private:
  struct Impl;
  const std::unique_ptr<Impl> impl_;
};

// For ServerBuilder. `metrics` outlives the server.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> MakeCallObservers(
    const CallMetrics* metrics);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_METRICS_CALL_OBSERVER_H_
