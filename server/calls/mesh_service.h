// MeshService over gRPC's callback API: decode, hand on, encode. Calls that stream
// live in edit_call, edit_stream_call, load_call and watch_call.
#ifndef DYNMESH_SERVER_CALLS_MESH_SERVICE_H_
#define DYNMESH_SERVER_CALLS_MESH_SERVICE_H_

#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "server/calls/admission.h"
#include "server/calls/open_streams.h"

namespace dynmesh::server {

// Thread-safe. The context outlives it.
class MeshServiceImpl final : public v1::MeshService::CallbackService {
 public:
  explicit MeshServiceImpl(ServiceContext* context) : context_(*context) {}

  // Refuses new work and ends all streams, after what they hold is answered.
  void BeginDrain();
  // Now and then: ends streams whose client leaves a batch unfinished, and calls whose client
  // does not take what they send.
  void Tick();

  grpc::ServerUnaryReactor* CreateMesh(grpc::CallbackServerContext* call,
                                       const v1::CreateMeshRequest* request,
                                       v1::Mesh* response) override;
  grpc::ServerUnaryReactor* GetMesh(grpc::CallbackServerContext* call,
                                    const v1::GetMeshRequest* request, v1::Mesh* response) override;
  grpc::ServerUnaryReactor* ListMeshes(grpc::CallbackServerContext* call,
                                       const v1::ListMeshesRequest* request,
                                       v1::ListMeshesResponse* response) override;
  grpc::ServerUnaryReactor* DeleteMesh(grpc::CallbackServerContext* call,
                                       const v1::DeleteMeshRequest* request,
                                       v1::DeleteMeshResponse* response) override;
  grpc::ServerUnaryReactor* GetStats(grpc::CallbackServerContext* call,
                                     const v1::GetStatsRequest* request,
                                     v1::GetStatsResponse* response) override;
  grpc::ServerUnaryReactor* LocatePoints(grpc::CallbackServerContext* call,
                                         const v1::LocatePointsRequest* request,
                                         v1::LocatePointsResponse* response) override;

  grpc::ServerWriteReactor<v1::MeshDiff>* AddFeatures(
      grpc::CallbackServerContext* call, const v1::AddFeaturesRequest* request) override;
  grpc::ServerWriteReactor<v1::MeshDiff>* RemoveFeatures(
      grpc::CallbackServerContext* call, const v1::RemoveFeaturesRequest* request) override;
  grpc::ServerWriteReactor<v1::MeshDiff>* ApplyEdits(grpc::CallbackServerContext* call,
                                                     const v1::ApplyEditsRequest* request) override;
  grpc::ServerBidiReactor<v1::EditBatch, v1::MeshDiff>* EditStream(
      grpc::CallbackServerContext* call) override;
  grpc::ServerBidiReactor<v1::LoadFeaturesRequest, v1::LoadFeaturesResponse>* LoadFeatures(
      grpc::CallbackServerContext* call) override;
  grpc::ServerWriteReactor<v1::WatchEvent>* Watch(grpc::CallbackServerContext* call,
                                                  const v1::WatchRequest* request) override;
  grpc::ServerWriteReactor<v1::SnapshotChunk>* GetSnapshot(
      grpc::CallbackServerContext* call, const v1::GetSnapshotRequest* request) override;
  grpc::ServerWriteReactor<v1::FeaturesChunk>* GetFeatures(
      grpc::CallbackServerContext* call, const v1::GetFeaturesRequest* request) override;
  grpc::ServerWriteReactor<v1::MeshDiff>* RevertTo(grpc::CallbackServerContext* call,
                                                   const v1::RevertToRequest* request) override;

 private:
  // Who calls and, with the other, that it has the role on the mesh of that name.
  absl::StatusOr<Pass> Admit(const grpc::CallbackServerContext* call);
  absl::StatusOr<Pass> Admit(const grpc::CallbackServerContext* call, Role role,
                             const std::string& mesh);

  ServiceContext& context_;
  OpenStreams streams_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_MESH_SERVICE_H_
