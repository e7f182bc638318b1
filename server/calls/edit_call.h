// One AddFeatures, RemoveFeatures, ApplyEdits or RevertTo: hands its batch to the mesh, then
// streams the diff fragment by fragment as the client takes them.
#ifndef DYNMESH_SERVER_CALLS_EDIT_CALL_H_
#define DYNMESH_SERVER_CALLS_EDIT_CALL_H_

#include <grpcpp/support/server_callback.h>

#include "dynmesh/v1/mesh_service.pb.h"
#include "server/calls/admission.h"

namespace dynmesh::server {

// Each starts a call that frees itself; one that was not admitted ends with why. `request` is not
// used after the return, `rpc` until the call is done.
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::AddFeaturesRequest& request,
                                                      const absl::Status& admitted,
                                                      grpc::CallbackServerContext* rpc);
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::RemoveFeaturesRequest& request,
                                                      const absl::Status& admitted,
                                                      grpc::CallbackServerContext* rpc);
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::ApplyEditsRequest& request,
                                                      const absl::Status& admitted,
                                                      grpc::CallbackServerContext* rpc);
// Its batch is made on a reader's thread first.
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::RevertToRequest& request,
                                                      const absl::Status& admitted,
                                                      grpc::CallbackServerContext* rpc);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_EDIT_CALL_H_
