// Observes every call of the gRPC server, as an interceptor: counts it, times it, gives it an id
// (call_id.h), and logs failures. The metrics have the names of the Prometheus middleware for gRPC.
// Methods of other services (reflection) and unknown methods share the label "other". Thread-safe;
// a few atomic operations per message.
#ifndef DYNMESH_SERVER_METRICS_CALL_OBSERVER_H_
#define DYNMESH_SERVER_METRICS_CALL_OBSERVER_H_

#include <grpcpp/support/server_interceptor.h>

#include <functional>
#include <memory>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "server/base/work_gate.h"
#include "server/metrics/failed_calls.h"
#include "server/metrics/metrics.h"

namespace dynmesh::server {

// What is told of calls to find clients that waste the server's time. `peer` is as gRPC names it.
// Functions of any thread.
struct CallJudge {
  // False: `answered` need not be called.
  std::function<bool()> wants_answered;
  // The first answer of a call, which is no refusal of any client.
  std::function<void(absl::string_view peer)> answered;
  // A call without a known token, one that its client cancelled at once, or one of another service,
  // which takes no token.
  std::function<void(absl::string_view peer)> wasted;
};

class CallMetrics {
 public:
  explicit CallMetrics(MetricRegistry& registry);
  ~CallMetrics();

  struct Method;
  Method& Find(const char* path) const;  // "/package.Service/Method"
  FailedCalls& failed() const;
  // A call of the service begins.
  WorkGate::Ticket Enter() const;
  // Before any call.
  void Judge(CallJudge judge);
  const CallJudge& judge() const;
  // The open calls of the service, until their last byte is with the transport. After Close it
  // counts no new ones: these are refused, and WaitQuiet has them.
  WorkGate& open() const;
  // After open() was closed: blocks until no refused call is open, and none has come for `quiet`.
  // False after `limit`. A connection that is closed before gives its calls no reason.
  bool WaitQuiet(absl::Duration quiet, absl::Duration limit) const;

 private:
  struct Impl;
  const std::unique_ptr<Impl> impl_;
};

// For ServerBuilder. `metrics` outlives the server.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> MakeCallObservers(
    const CallMetrics* metrics);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_METRICS_CALL_OBSERVER_H_
