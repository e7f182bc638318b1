// One AddFeatures, RemoveFeatures, ApplyEdits or RevertTo: hands its batch to the mesh, then
// streams the diff fragment by fragment as the client takes them.
#ifndef DYNMESH_SERVER_CALLS_EDIT_CALL_H_
#define DYNMESH_SERVER_CALLS_EDIT_CALL_H_

#include <grpcpp/support/server_callback.h>

#include <string>

#include "dynmesh/v1/mesh_service.pb.h"
#include "server/calls/admission.h"

namespace dynmesh::server {

// Each starts a call that frees itself; one that was not admitted ends with why. `request` is not
// used after the return. `call_id`: call_id.h.
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::AddFeaturesRequest& request,
                                                      const absl::Status& admitted,
                                                      std::string call_id);
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::RemoveFeaturesRequest& request,
                                                      const absl::Status& admitted,
                                                      std::string call_id);
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::ApplyEditsRequest& request,
                                                      const absl::Status& admitted,
                                                      std::string call_id);
// Its batch is made on a reader's thread first.
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::RevertToRequest& request,
                                                      const absl::Status& admitted,
                                                      std::string call_id);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_EDIT_CALL_H_
