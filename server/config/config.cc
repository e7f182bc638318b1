#include "server/config/config.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cmath>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace dynmesh::server {
namespace {

absl::Status Bad(const char* field, const char* what) {
  return absl::InvalidArgumentError(absl::StrCat(field, " ", what));
}

absl::Status ValidateExposure(const ServerConfig& c) {
  if (c.tls.certificate.empty() != c.tls.key.empty()) {
    return Bad("tls-cert", "and tls-key belong together: give both or none");
  }
  if (!c.tls.client_ca.empty() && !c.tls.enabled()) {
    return Bad("tls-client-ca", "needs tls-cert and tls-key");
  }
  if (!IsLoopback(c.listen) && !c.tls.enabled() && !c.insecure_listen) {
    return absl::InvalidArgumentError(absl::StrCat(
        "listen: ", c.listen,
        " can be reached from elsewhere, and nothing would be encrypted: give --tls-cert and "
        "--tls-key, or --insecure-listen if the network is to be trusted"));
  }
  const bool is_port = std::all_of(c.http.begin(), c.http.end(), absl::ascii_isdigit);
  if (!is_port && !IsLoopback(c.http) && !c.insecure_listen) {
    return absl::InvalidArgumentError(absl::StrCat(
        "http: ", c.http,
        " can be reached from elsewhere, and nothing would be encrypted: listen on loopback and "
        "put a proxy with TLS before it, or give --insecure-listen if the network is to be "
        "trusted"));
  }
  return absl::OkStatus();
}

absl::Status ValidateConnections(const ServerConfig& c) {
  if (!(c.max_requests_per_second >= 0) || std::isinf(c.max_requests_per_second)) {
    return Bad("max-requests-per-second", "must be 0 or more");
  }
  if (c.max_streams_per_connection < 1) {
    return Bad("max-streams-per-connection", "must be at least 1");
  }
  if (c.max_http_connections == 0 || c.max_http_connections > 10'000) {
    return Bad("max-http-connections", "not in 1..10000");
  }
  if (c.max_connections == 0) return Bad("max-connections", "must be at least 1");
  for (const auto& [field, rate] :
       {std::pair{"max-new-connections-per-second", c.max_new_connections_per_second},
        std::pair{"max-wasted-calls-per-second", c.max_wasted_calls_per_second}}) {
    if (!(rate >= 0) || std::isinf(rate)) return Bad(field, "must be 0 or more");
  }
  for (const auto& [field, duration] : {std::pair{"handshake-timeout", c.handshake_timeout},
                                        std::pair{"keepalive-interval", c.keepalive_interval},
                                        std::pair{"keepalive-timeout", c.keepalive_timeout},
                                        std::pair{"idle-timeout", c.idle_timeout}}) {
    if (duration < absl::Milliseconds(100) || duration > absl::Hours(24)) {
      return Bad(field, "not in 0.1 s to a day");
    }
  }
  return absl::OkStatus();
}

// HOST or HOST:PORT, as in the address that a client is given.
absl::Status ValidateNode(const ServerConfig& c) {
  if (c.lease < absl::Milliseconds(100) || c.lease > absl::Hours(1)) {
    return Bad("lease", "not in 0.1 s to an hour");
  }
  if (c.followers > 16) return Bad("followers", "not in 0..16");
  if (c.follower_idle < absl::Seconds(1) || c.follower_idle > absl::Hours(24)) {
    return Bad("follower-idle", "not in 1 s to a day");
  }
  const absl::string_view address = c.node_address;
  const bool good = address.size() <= 255 &&
                    std::all_of(address.begin(), address.end(),
                                [](char x) { return x > ' ' && x < 0x7f && x != '/' && x != ','; });
  if (!good || absl::StartsWith(address, ":")) {
    return Bad("node-address", "is not of the form HOST or HOST:PORT");
  }
  if (!address.empty() && absl::StartsWith(c.listen, "unix:")) {
    return Bad("node-address", "needs a port to listen on, not a socket in a folder");
  }
  return absl::OkStatus();
}

}  // namespace

bool IsLoopback(absl::string_view listen) {
  if (absl::StartsWith(listen, "unix:")) return true;
  const absl::string_view host = listen.substr(0, listen.rfind(':'));
  if (host == "localhost" || host == "[::1]") return true;
  in_addr address{};
  return inet_pton(AF_INET, std::string(host).c_str(), &address) == 1 &&
         (ntohl(address.s_addr) >> 24) == 127;
}

absl::Status ValidateConfig(const ServerConfig& c) {
  if (c.listen.empty()) return Bad("listen", "is empty: give host:port");
  if (absl::Status status = ValidateExposure(c); !status.ok()) return status;
  if (absl::Status status = ValidateConnections(c); !status.ok()) return status;
  if (absl::Status status = ValidateNode(c); !status.ok()) return status;
  if (c.writer_threads < 0 || c.writer_threads > 1024)
    return Bad("writer-threads", "not in 0..1024");
  if (c.reader_threads < 0 || c.reader_threads > 1024)
    return Bad("reader-threads", "not in 0..1024");
  if (c.max_meshes == 0) return Bad("max-meshes", "must be at least 1");
  if (c.max_features == 0) return Bad("max-features", "must be at least 1");
  if (c.max_batch_edits == 0) return Bad("max-batch-edits", "must be at least 1");
  if (c.max_pending_edits < c.max_batch_edits) {
    return Bad("max-pending-edits", "must be at least max-batch-edits");
  }
  if (c.max_message_bytes < 64 << 10) return Bad("max-message-bytes", "must be at least 65536");
  if (c.max_waiting_edits == 0) return Bad("max-waiting-edits", "must be at least 1");
  if (c.edit_window < 1) return Bad("edit-window", "must be at least 1");
  if (c.history_revisions == 0) return Bad("history-revisions", "must be at least 1");
  if (c.progress_interval < absl::Milliseconds(100)) {
    return Bad("progress-interval", "must be at least 100 ms");
  }
  if (c.report_interval <= absl::ZeroDuration()) return Bad("report-interval", "must be positive");
  if (c.batch_timeout <= absl::ZeroDuration()) return Bad("batch-timeout", "must be positive");
  if (c.send_timeout < absl::ZeroDuration() || c.send_timeout > absl::Hours(24)) {
    return Bad("send-timeout", "not in 0 s to a day");
  }
  if (c.max_builds > 1024) return Bad("max-builds", "not in 0..1024");
  if (c.max_build_time < absl::ZeroDuration() || c.max_build_time > absl::Hours(24)) {
    return Bad("max-build-seconds", "not in 0 s to a day");
  }
  if (c.drain_timeout < absl::ZeroDuration()) return Bad("drain-timeout", "is negative");
  return absl::OkStatus();
}

}  // namespace dynmesh::server
