// The peer of a connection in gRPC's format: "ipv4:127.0.0.1:54321". Pure.
#ifndef DYNMESH_SERVER_BASE_PEER_H_
#define DYNMESH_SERVER_BASE_PEER_H_

#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace dynmesh::server {

// Without the port.
inline absl::string_view AddressOf(absl::string_view peer) {
  return peer.substr(0, peer.rfind(':'));
}

// The name of a client without a token, in the log and in errors. No token's name begins so.
inline std::string ClientAt(absl::string_view address) { return absl::StrCat("address ", address); }

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_PEER_H_
