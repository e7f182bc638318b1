// Sockets that listen on a TCP address.
#ifndef DYNMESH_SERVER_BASE_LISTENING_H_
#define DYNMESH_SERVER_BASE_LISTENING_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace dynmesh::server {

struct Listening {
  std::vector<int> sockets;  // one for each address of the host; the caller closes them
  int port = 0;
};

// Listens on all addresses of `host`, a name or an address without brackets. `port` 0 picks a free
// one, the same for all. The sockets do not block, and are closed by exec. UNAVAILABLE, with the
// reason, if none can be bound, as when another process has the port.
absl::StatusOr<Listening> ListenOn(const std::string& host, const std::string& port);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_LISTENING_H_
