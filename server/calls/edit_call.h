// An AddFeatures, RemoveFeatures, ApplyEdits or RevertTo call: submits its batch to the mesh, then
// streams the diff in fragments at the client's pace.
#ifndef DYNMESH_SERVER_CALLS_EDIT_CALL_H_
#define DYNMESH_SERVER_CALLS_EDIT_CALL_H_

#include <grpcpp/support/server_callback.h>

#include "dynmesh/v1/mesh_service.pb.h"
#include "server/calls/admission.h"
#include "server/calls/open_streams.h"

namespace dynmesh::server {

// Each starts a call that frees itself, and puts it into `streams`: Cancel undoes a batch that is
// not applied yet. Without a pass it ends with the error. `request` is not used after the return;
// `rpc` is used until the call is done.
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context, OpenStreams& streams,
                                                      const v1::AddFeaturesRequest& request,
                                                      const absl::StatusOr<Pass>& pass,
                                                      grpc::CallbackServerContext* rpc);
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context, OpenStreams& streams,
                                                      const v1::RemoveFeaturesRequest& request,
                                                      const absl::StatusOr<Pass>& pass,
                                                      grpc::CallbackServerContext* rpc);
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context, OpenStreams& streams,
                                                      const v1::ApplyEditsRequest& request,
                                                      const absl::StatusOr<Pass>& pass,
                                                      grpc::CallbackServerContext* rpc);
// The batch is made on a reader's thread first.
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context, OpenStreams& streams,
                                                      const v1::RevertToRequest& request,
                                                      const absl::StatusOr<Pass>& pass,
                                                      grpc::CallbackServerContext* rpc);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_EDIT_CALL_H_
