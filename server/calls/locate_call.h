// LocatePoints: waits for the mesh, then for its turn among the edits.
#ifndef DYNMESH_SERVER_CALLS_LOCATE_CALL_H_
#define DYNMESH_SERVER_CALLS_LOCATE_CALL_H_

#include <grpcpp/support/server_callback.h>

#include "dynmesh/v1/mesh_service.pb.h"
#include "server/base/work_gate.h"
#include "server/calls/admission.h"
#include "server/calls/forwarder.h"

namespace dynmesh::server {

// For an admitted call with a ticket. The reactor frees itself; request and response live until the
// call is finished.
grpc::ServerUnaryReactor* StartLocateCall(ServiceContext& context, Forwarder& forwarder,
                                          const v1::LocatePointsRequest& request,
                                          v1::LocatePointsResponse* response, const Pass& pass,
                                          WorkGate::Ticket ticket,
                                          grpc::CallbackServerContext* rpc);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_LOCATE_CALL_H_
