// Observes every call of the gRPC server, as an interceptor: counts it, times it, gives it an id
// (call_id.h), and logs failures. The metrics have the names of the Prometheus middleware for gRPC.
// Methods of other services (reflection) and unknown methods share the label "other". Thread-safe;
// a few atomic operations per message.
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
  // The open calls of the service, until their last byte is with the transport. After Close it
  // counts no new ones.
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
