// Sockets that listen on a TCP address.
#ifndef DYNMESH_SERVER_BASE_LISTENING_H_
#define DYNMESH_SERVER_BASE_LISTENING_H_

#include <chrono>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dynmesh::server {

struct HostPort {
  std::string host;  // a name or an address without brackets
  int port = 0;
};
// Of [HOST:]PORT; without a host 127.0.0.1. INVALID_ARGUMENT, naming `option`, for other texts.
absl::StatusOr<HostPort> ParseHostPort(absl::string_view option, absl::string_view text);
// HOST:PORT, with brackets where the host has colons.
std::string AddressText(const HostPort& address);

struct Listening {
  std::vector<int> sockets;  // one for each address of the host; the caller closes them
  int port = 0;
};

// Listens on all addresses of `host`, a name or an address without brackets. `port` 0 picks a free
// one, the same for all. The sockets do not block, and are closed by exec. UNAVAILABLE, with the
// reason, if none can be bound, as when another process has the port.
absl::StatusOr<Listening> ListenOn(const std::string& host, const std::string& port);

// Until the next try to accept a connection when there was no descriptor for it.
inline constexpr std::chrono::milliseconds kAcceptRetry{50};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_LISTENING_H_
