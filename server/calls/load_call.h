// A LoadFeatures call: parts in, applied as one batch; progress and the result out.
//
// Nothing is applied before the last part has arrived. A load that ends earlier changes nothing;
// one that is cancelled later is undone. Its edits count as pending edits.
#ifndef DYNMESH_SERVER_CALLS_LOAD_CALL_H_
#define DYNMESH_SERVER_CALLS_LOAD_CALL_H_

#include <grpcpp/support/server_callback.h>

#include "dynmesh/v1/mesh_service.pb.h"
#include "server/calls/admission.h"
#include "server/calls/open_streams.h"
#include "server/calls/received.h"

namespace dynmesh::server {

// As StartEditStreamCall.
grpc::ServerBidiReactor<Received<v1::LoadFeaturesRequest>, v1::LoadFeaturesResponse>* StartLoadCall(
    ServiceContext& context, OpenStreams& streams, const absl::StatusOr<Pass>& pass,
    grpc::CallbackServerContext* rpc);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_LOAD_CALL_H_
