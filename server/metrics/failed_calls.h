// Calls that failed: counted by their reason, and told to the log. Those that a client can do
// something about are of interest to whoever looks for that client, but there may be thousands a
// second: of each reason at most one line a second, with how many were left out before it.
// Thread-safe.
#ifndef DYNMESH_SERVER_METRICS_FAILED_CALLS_H_
#define DYNMESH_SERVER_METRICS_FAILED_CALLS_H_

#include <grpcpp/support/status.h>

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "absl/strings/string_view.h"
#include "server/metrics/metrics.h"
#include "server/metrics/server_metrics.h"

namespace dynmesh::server {

class FailedCalls {
 public:
  explicit FailedCalls(MetricRegistry& registry);

  struct Call {
    absl::string_view id;
    absl::string_view method;
    absl::string_view code;  // the name of the status's
    std::string peer;        // address and port
  };
  // Once for each. What failed through the server's own doing is a warning. A refusal (no token, no
  // right, a limit) is an info line, call_refused, as above. All else is of interest in debugging.
  void Tell(const Call& call, const grpc::Status& status);

 private:
  struct Told {
    MetricsClock::time_point last;
    std::uint64_t left_out = 0;
  };
  // How many refusals of that reason were left out before this one, or nothing if this one is.
  std::optional<std::uint64_t> TakeLine(const std::string& reason);

  MetricFamily<Counter>& by_reason_;
  std::mutex mutex_;
  std::map<std::string, Told> told_;  // by reason, of which there are few
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_METRICS_FAILED_CALLS_H_
