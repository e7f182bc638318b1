// MeshService over gRPC's callback API: decodes, delegates, encodes. The streaming calls are in
// build_call, edit_call, edit_stream_call, load_call and watch_call.
#ifndef DYNMESH_SERVER_CALLS_MESH_SERVICE_H_
#define DYNMESH_SERVER_CALLS_MESH_SERVICE_H_

#include <grpcpp/impl/service_type.h>
#include <grpcpp/support/server_callback.h>

#include <deque>
#include <string>

#include "dynmesh/v1/mesh_service.pb.h"
#include "server/calls/admission.h"
#include "server/calls/forwarder.h"
#include "server/calls/open_streams.h"
#include "server/calls/received.h"

namespace dynmesh::server {

// Registers the methods itself, as the generated class does, but with Received messages. Each
// method begins with Admit. Thread-safe. The context outlives it.
class MeshServiceImpl final : public grpc::Service {
 public:
  // `neighbours`: for connections to the other servers of a journal; null: no call is handed on.
  explicit MeshServiceImpl(ServiceContext* context,
                           std::shared_ptr<grpc::ChannelCredentials> neighbours = nullptr);

  // Refuses new work and ends all streams after their complete batches are answered.
  void BeginDrain();
  // Cancels the batches that are not applied yet: they are answered as calls refused in the drain.
  void CancelEdits() { streams_.CancelAll(DrainingError()); }
  // Ends the calls that are still open, with the reason: gRPC itself would not name one.
  void CutCalls();
  // To be called periodically: ends streams with an unfinished batch that waits too long, and calls
  // with a message that the client does not take.
  void Tick();

 private:
  // Registers the method with that name in the proto.
  void Register(const char* name, grpc::internal::MethodHandler* handler);
  template <typename Request, typename Response>
  void RegisterUnary(const char* name,
                     grpc::ServerUnaryReactor* (MeshServiceImpl::*method)(
                         grpc::CallbackServerContext*, const Request*, Response*));
  template <typename Request, typename Response>
  void RegisterServerStream(const char* name,
                            grpc::ServerWriteReactor<Response>* (MeshServiceImpl::*method)(
                                grpc::CallbackServerContext*, const Request*));
  template <typename Request, typename Response>
  void RegisterBidiStream(const char* name,
                          grpc::ServerBidiReactor<Received<Request>, Response>* (
                              MeshServiceImpl::*method)(grpc::CallbackServerContext*));

  grpc::ServerUnaryReactor* CreateMesh(grpc::CallbackServerContext* call,
                                       const v1::CreateMeshRequest* request, v1::Mesh* response);
  grpc::ServerUnaryReactor* GetMesh(grpc::CallbackServerContext* call,
                                    const v1::GetMeshRequest* request, v1::Mesh* response);
  grpc::ServerUnaryReactor* ListMeshes(grpc::CallbackServerContext* call,
                                       const v1::ListMeshesRequest* request,
                                       v1::ListMeshesResponse* response);
  grpc::ServerUnaryReactor* DeleteMesh(grpc::CallbackServerContext* call,
                                       const v1::DeleteMeshRequest* request,
                                       v1::DeleteMeshResponse* response);
  grpc::ServerUnaryReactor* GetStats(grpc::CallbackServerContext* call,
                                     const v1::GetStatsRequest* request,
                                     v1::GetStatsResponse* response);
  grpc::ServerUnaryReactor* LocatePoints(grpc::CallbackServerContext* call,
                                         const v1::LocatePointsRequest* request,
                                         v1::LocatePointsResponse* response);

  grpc::ServerWriteReactor<v1::MeshDiff>* AddFeatures(grpc::CallbackServerContext* call,
                                                      const v1::AddFeaturesRequest* request);
  grpc::ServerWriteReactor<v1::MeshDiff>* RemoveFeatures(grpc::CallbackServerContext* call,
                                                         const v1::RemoveFeaturesRequest* request);
  grpc::ServerWriteReactor<v1::MeshDiff>* ApplyEdits(grpc::CallbackServerContext* call,
                                                     const v1::ApplyEditsRequest* request);
  grpc::ServerBidiReactor<Received<v1::EditBatch>, v1::MeshDiff>* EditStream(
      grpc::CallbackServerContext* call);
  grpc::ServerBidiReactor<Received<v1::LoadFeaturesRequest>, v1::LoadFeaturesResponse>*
  LoadFeatures(grpc::CallbackServerContext* call);
  grpc::ServerWriteReactor<grpc::ByteBuffer>* Watch(grpc::CallbackServerContext* call,
                                                    const v1::WatchRequest* request);
  grpc::ServerWriteReactor<v1::SnapshotChunk>* GetSnapshot(grpc::CallbackServerContext* call,
                                                           const v1::GetSnapshotRequest* request);
  grpc::ServerWriteReactor<v1::FeaturesChunk>* GetFeatures(grpc::CallbackServerContext* call,
                                                           const v1::GetFeaturesRequest* request);
  grpc::ServerWriteReactor<v1::MeshDiff>* RevertTo(grpc::CallbackServerContext* call,
                                                   const v1::RevertToRequest* request);
  grpc::ServerBidiReactor<Received<v1::BuildMeshRequest>, v1::BuildMeshResponse>* BuildMesh(
      grpc::CallbackServerContext* call);

  // The answer to a call without a parsable message. It has to be admitted first, as any other.
  absl::Status Refuse(const grpc::CallbackServerContext* call,
                      const google::protobuf::MessageLite& message);
  // Authenticates the caller; the second form also checks the role on the named mesh.
  absl::StatusOr<Pass> Admit(const grpc::CallbackServerContext* call);
  absl::StatusOr<Pass> Admit(const grpc::CallbackServerContext* call, Role role,
                             const std::string& mesh);

  ServiceContext& context_;
  OpenStreams streams_;  // and the calls of one batch
  Forwarder forwarder_;
  std::deque<std::string> paths_;  // of the methods
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_MESH_SERVICE_H_
