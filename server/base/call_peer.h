// The client's end of the connection that a call came on, in gRPC's format. Thread-safe.
#ifndef DYNMESH_SERVER_BASE_CALL_PEER_H_
#define DYNMESH_SERVER_BASE_CALL_PEER_H_

#include <grpcpp/server_context.h>

#include <string>

namespace dynmesh::server {

// The metadata's key of a call that came over HTTP: its value is the client's end. Random in each
// process, so that nothing from outside is believed.
const std::string& HttpPeerKey();

std::string PeerOf(const grpc::ServerContextBase& call);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_CALL_PEER_H_
