// One AddFeatures, RemoveFeatures or ApplyEdits: hands its batch to the mesh, then
// streams the diff fragment by fragment as the client takes them.
#ifndef DYNMESH_SERVER_EDIT_CALL_H_
#define DYNMESH_SERVER_EDIT_CALL_H_

#include <grpcpp/support/server_callback.h>

#include "dynmesh/v1/mesh_service.pb.h"
#include "server/admission.h"

namespace dynmesh::server {

// Each starts a call that frees itself. `request` is not used after the return.
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::AddFeaturesRequest& request);
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::RemoveFeaturesRequest& request);
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::ApplyEditsRequest& request);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_EDIT_CALL_H_
