// Failed calls: counted by reason, and logged. There may be thousands of them per second, so at
// most one line a second is logged for each reason, with the number left out before it.
// Thread-safe.
#ifndef DYNMESH_SERVER_METRICS_FAILED_CALLS_H_
#define DYNMESH_SERVER_METRICS_FAILED_CALLS_H_

#include <grpcpp/support/status.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/string_view.h"
#include "core/base/mutex.h"
#include "server/metrics/metrics.h"
#include "server/metrics/server_metrics.h"

namespace dynmesh::server {

class FailedCalls {
 public:
  explicit FailedCalls(MetricRegistry& registry);

  // `holders` gives the clients that have most of a limit, by the limit's name in an error's
  // metadata, for the log only: the refused client does not learn the names of others. Before any
  // call.
  void NameHolders(std::function<std::string(const std::string& limit)> holders) {
    holders_ = std::move(holders);
  }

  struct Call {
    absl::string_view id;
    absl::string_view method;
    absl::string_view code;  // name of the status code
    std::string peer;        // address and port
  };
  // To be called once per failed call. A failure caused by the server is logged as a warning. A
  // refusal (no token, missing role, a limit) is logged as an info line call_refused. Both are
  // limited as above: gRPC answers INTERNAL for what a client resets in its own services. All else
  // is logged at debug level.
  void Tell(const Call& call, const grpc::Status& status);

 private:
  struct Told {
    MetricsClock::time_point last;
    std::uint64_t left_out = 0;
  };
  // How many lines of that reason were left out before this one; nothing if this one is left out.
  std::optional<std::uint64_t> TakeLine(const std::string& reason);

  MetricFamily<Counter>& by_reason_;
  std::function<std::string(const std::string&)> holders_;
  Mutex mutex_;
  std::map<std::string, Told> told_ ABSL_GUARDED_BY(mutex_);  // by reason, or by code; few exist
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_METRICS_FAILED_CALLS_H_
