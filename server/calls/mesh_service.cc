#include "server/calls/mesh_service.h"

#include <google/protobuf/descriptor.h>
#include <grpcpp/impl/rpc_service_method.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "dynmesh/version.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "proto/codec/status_codec.h"
#include "server/base/call_id.h"
#include "server/base/call_peer.h"
#include "server/base/peer.h"
#include "server/calls/asking.h"
#include "server/calls/build_call.h"
#include "server/calls/edit_call.h"
#include "server/calls/edit_stream_call.h"
#include "server/calls/features_call.h"
#include "server/calls/load_call.h"
#include "server/calls/locate_call.h"
#include "server/calls/requests.h"
#include "server/calls/send_timeout.h"
#include "server/calls/snapshot_call.h"
#include "server/calls/watch_call.h"

namespace dynmesh::server {
namespace {

constexpr int kDefaultPageSize = 100;
constexpr int kMaxPageSize = 1000;

void EncodeMesh(const MeshHost& host, v1::Mesh* out) {
  const Head head = host.head();
  out->set_name(MeshName(host.id()));
  codec::EncodeOptions(host.mesh_options(), out->mutable_options());
  codec::EncodeTime(host.create_time(), out->mutable_create_time());
  out->set_revision(head.revision);
  out->set_hash(head.hash.ToHex());
  if (!host.read_only().ok()) out->set_damage(std::string(host.read_only().message()));
}

// The first `count` of the meshes, and the next page's token if there are more.
void EncodeList(const std::vector<MeshRegistry::Listed>& meshes, std::size_t count,
                v1::ListMeshesResponse* out) {
  for (std::size_t i = 0; i < std::min(meshes.size(), count); ++i) {
    const MeshRegistry::Listed& listed = meshes[i];
    v1::Mesh* const mesh = out->add_meshes();
    if (listed.host != nullptr) {
      EncodeMesh(*listed.host, mesh);
      continue;
    }
    mesh->set_name(MeshName(listed.id));
    mesh->set_damage(std::string(listed.damage.message()));
    if (listed.owner.empty()) continue;
    mesh->set_owner(listed.owner);
    mesh->set_revision(listed.revision);
    codec::EncodeTime(listed.create_time, mesh->mutable_create_time());
  }
  if (meshes.size() > count) out->set_next_page_token(meshes[count - 1].id);
}

void EncodeStats(const MeshHost& host, v1::MeshStats* out) {
  const Head head = host.head();
  const MeshStats stats = host.stats();
  out->set_revision(head.revision);
  out->set_hash(head.hash.ToHex());
  out->set_features(stats.features);
  out->set_vertices(stats.vertices);
  out->set_simplices(stats.simplices);
  out->set_subsegments(stats.subsegments);
  out->set_operations(stats.operations);
  out->set_trace_bytes(stats.trace_bytes);
  out->set_mesh_bytes(stats.mesh_bytes);
  out->set_oldest_revision(host.store()->oldest());
  out->set_watchers(host.hub()->size());
  out->set_waiting_edits(host.waiting());
  out->set_subfacets(stats.subfacets);
  out->set_dimension(host.mesh_options().dimension);
}

grpc::ServerUnaryReactor* Finished(grpc::CallbackServerContext* call, const absl::Status& status) {
  auto* reactor = call->DefaultReactor();
  reactor->Finish(codec::ToGrpcStatus(status));
  return reactor;
}

// Records whether the call was cancelled.
class CreateReactor final : public grpc::ServerUnaryReactor {
 public:
  const std::atomic<bool>* cancelled() const { return &cancelled_; }

 private:
  void OnCancel() override { cancelled_ = true; }
  void OnDone() override { delete this; }

  std::atomic<bool> cancelled_{false};
};

// The caller's identity. Valid as long as `call` and `peer`.
Caller CallerOf(const grpc::CallbackServerContext& call, const std::string& peer) {
  Caller caller;
  // Of two headers neither is used: other servers might choose the other one.
  const auto [begin, end] = call.client_metadata().equal_range("authorization");
  if (begin != end) {
    caller.authorization = std::next(begin) == end
                               ? absl::string_view(begin->second.data(), begin->second.size())
                               : absl::string_view();
  }
  caller.address = AddressOf(peer);
  return caller;
}

// What the creation of a mesh is remembered by. Two clients may use the same request_id, and one
// client may use one with and without a name. The journal keeps it. Ids of before, which are
// request_ids alone, do not begin so.
std::string CreationId(const Pass& pass, const v1::CreateMeshRequest& request) {
  if (request.request_id().empty()) return "";
  return absl::StrCat("\x1f", request.mesh_id().empty() ? "fresh" : "named", " ", pass.name(),
                      "\x1f", request.request_id());
}

// Ends a streaming call before anything was sent.
template <typename Response>
class FailedCall final : public grpc::ServerWriteReactor<Response> {
 public:
  explicit FailedCall(const absl::Status& status) { this->Finish(codec::ToGrpcStatus(status)); }
  void OnDone() override { delete this; }
};

grpc::internal::RpcMethod::RpcType RpcTypeOf(const google::protobuf::MethodDescriptor& method) {
  using Rpc = grpc::internal::RpcMethod;
  if (method.client_streaming()) {
    return method.server_streaming() ? Rpc::BIDI_STREAMING : Rpc::CLIENT_STREAMING;
  }
  return method.server_streaming() ? Rpc::SERVER_STREAMING : Rpc::NORMAL_RPC;
}

const google::protobuf::ServiceDescriptor& Descriptor() {
  return *v1::GetMeshRequest::descriptor()->file()->FindServiceByName("MeshService");
}

}  // namespace

MeshServiceImpl::MeshServiceImpl(ServiceContext* context,
                                 std::shared_ptr<grpc::ChannelCredentials> neighbours)
    : context_(*context), forwarder_(std::move(neighbours)) {
  const google::protobuf::ServiceDescriptor& service = Descriptor();
  for (int i = 0; i < service.method_count(); ++i) {
    const google::protobuf::MethodDescriptor& method = *service.method(i);
    paths_.push_back(absl::StrCat("/", service.full_name(), "/", method.name()));
    AddMethod(
        new grpc::internal::RpcServiceMethod(paths_.back().c_str(), RpcTypeOf(method), nullptr));
  }
  RegisterUnary("CreateMesh", &MeshServiceImpl::CreateMesh);
  RegisterUnary("GetMesh", &MeshServiceImpl::GetMesh);
  RegisterUnary("ListMeshes", &MeshServiceImpl::ListMeshes);
  RegisterUnary("DeleteMesh", &MeshServiceImpl::DeleteMesh);
  RegisterUnary("GetStats", &MeshServiceImpl::GetStats);
  RegisterUnary("LocatePoints", &MeshServiceImpl::LocatePoints);
  RegisterServerStream("AddFeatures", &MeshServiceImpl::AddFeatures);
  RegisterServerStream("RemoveFeatures", &MeshServiceImpl::RemoveFeatures);
  RegisterServerStream("ApplyEdits", &MeshServiceImpl::ApplyEdits);
  RegisterServerStream("Watch", &MeshServiceImpl::Watch);
  RegisterServerStream("GetSnapshot", &MeshServiceImpl::GetSnapshot);
  RegisterServerStream("GetFeatures", &MeshServiceImpl::GetFeatures);
  RegisterServerStream("RevertTo", &MeshServiceImpl::RevertTo);
  RegisterBidiStream("EditStream", &MeshServiceImpl::EditStream);
  RegisterBidiStream("LoadFeatures", &MeshServiceImpl::LoadFeatures);
  RegisterBidiStream("BuildMesh", &MeshServiceImpl::BuildMesh);
}

void MeshServiceImpl::Register(const char* name, grpc::internal::MethodHandler* handler) {
  MarkMethodCallback(Descriptor().FindMethodByName(name)->index(), handler);
}

template <typename Request, typename Response>
void MeshServiceImpl::RegisterUnary(const char* name,
                                    grpc::ServerUnaryReactor* (MeshServiceImpl::*method)(
                                        grpc::CallbackServerContext*, const Request*, Response*)) {
  Register(name, new grpc::internal::CallbackUnaryHandler<Received<Request>, Response>(
                     [this, method](grpc::CallbackServerContext* call,
                                    const Received<Request>* request, Response* response) {
                       if (request->is_parsed) {
                         return (this->*method)(call, &request->message, response);
                       }
                       return Finished(call, Refuse(call, request->message));
                     }));
}

template <typename Request, typename Response>
void MeshServiceImpl::RegisterServerStream(
    const char* name,
    grpc::ServerWriteReactor<Response>* (MeshServiceImpl::*method)(grpc::CallbackServerContext*,
                                                                   const Request*)) {
  Register(name, new grpc::internal::CallbackServerStreamingHandler<Received<Request>, Response>(
                     [this, method](
                         grpc::CallbackServerContext* call,
                         const Received<Request>* request) -> grpc::ServerWriteReactor<Response>* {
                       if (request->is_parsed) return (this->*method)(call, &request->message);
                       return new FailedCall<Response>(Refuse(call, request->message));
                     }));
}

template <typename Request, typename Response>
void MeshServiceImpl::RegisterBidiStream(
    const char* name, grpc::ServerBidiReactor<Received<Request>, Response>* (
                          MeshServiceImpl::*method)(grpc::CallbackServerContext*)) {
  Register(name, new grpc::internal::CallbackBidiHandler<Received<Request>, Response>(
                     [this, method](grpc::CallbackServerContext* call) {
                       return (this->*method)(call);
                     }));
}

absl::Status NotParsed(const google::protobuf::MessageLite& message) {
  codec::ServiceError error;
  error.reason = codec::reason::kBadRequest;
  return codec::MakeServiceError(
      absl::StatusCode::kInvalidArgument,
      absl::StrCat("the message is no ", message.GetTypeName(),
                   ": its bytes are no protobuf message of that type, or a string in it is not "
                   "UTF-8"),
      error);
}

absl::Status MeshServiceImpl::Refuse(const grpc::CallbackServerContext* call,
                                     const google::protobuf::MessageLite& message) {
  const absl::Status admitted = Admit(call).status();
  return admitted.ok() ? NotParsed(message) : admitted;
}

absl::StatusOr<Pass> MeshServiceImpl::Admit(const grpc::CallbackServerContext* call) {
  absl::StatusOr<Pass> pass = context_.access->Admit(CallerOf(*call, PeerOf(*call)));
  if (pass.ok() && context_.recovering.load(std::memory_order_relaxed)) return RecoveringError();
  return pass;
}

absl::StatusOr<Pass> MeshServiceImpl::Admit(const grpc::CallbackServerContext* call, Role role,
                                            const std::string& mesh) {
  absl::StatusOr<Pass> pass = Admit(call);
  if (!pass.ok()) return pass;
  if (absl::Status status = pass->Check(role, mesh); !status.ok()) return status;
  return pass;
}

void MeshServiceImpl::BeginDrain() {
  context_.gate.Close();
  streams_.EndAll(DrainingError());
  context_.registry->CloseOpening(DrainingError());
  context_.registry->CloseWatches(DrainingError());
}

void MeshServiceImpl::CutCalls() {
  streams_.CutAll(absl::StrCat(codec::reason::kDraining,
                               ": the server ended before it answered; repeat the call when a "
                               "server is back, an edit with the same request_id"));
}

void MeshServiceImpl::Tick() {
  EndSlowReceivers(context_);
  codec::ServiceError error;
  error.reason = codec::reason::kBatchIncomplete;
  const absl::Duration limit = context_.config.batch_timeout;
  streams_.EndWaiting(
      absl::ToChronoNanoseconds(limit),
      codec::MakeServiceError(absl::StatusCode::kDeadlineExceeded,
                              absl::StrCat("no first message, or no further part of the batch, "
                                           "came for ",
                                           absl::FormatDuration(limit), ": it was not applied"),
                              error));
}

grpc::ServerUnaryReactor* MeshServiceImpl::CreateMesh(grpc::CallbackServerContext* call,
                                                      const v1::CreateMeshRequest* request,
                                                      v1::Mesh* response) {
  const absl::StatusOr<Pass> pass = Admit(call);
  if (!pass.ok()) return Finished(call, pass.status());
  if (absl::Status s = pass->CheckId(Role::kAdmin, request->mesh_id()); !s.ok()) {
    return Finished(call, s);
  }
  absl::StatusOr<WorkGate::Ticket> ticket = EnterWork(context_);
  if (!ticket.ok()) return Finished(call, ticket.status());
  if (absl::Status s = CheckRequestId(request->request_id()); !s.ok()) return Finished(call, s);
  absl::StatusOr<MeshOptions> options = codec::DecodeOptions(
      request->options(),
      context_.registry->MaxVertices(request->options().dimension() == 3 ? 3 : 2));
  if (!options.ok()) return Finished(call, options.status());
  if (absl::Status s = CheckBoxOfNew(*options); !s.ok()) return Finished(call, s);
  auto* reactor = new CreateReactor();
  // Request and response live until the call is finished.
  context_.writers->Post(
      [this, reactor, call, request, response, options = *options, held = *ticket,
       asking = AskingOf(*call), id = CreationId(*pass, *request),
       origin = MeshRegistry::Origin{pass->client(), CallIdOf(*call)}]() mutable {
        const auto host = context_.registry->Create(request->mesh_id(), options, id,
                                                    reactor->cancelled(), origin);
        const auto answer = [this, reactor, call, request,
                             response](const absl::StatusOr<MeshRegistry::HostPtr>& made) {
          if (made.ok()) EncodeMesh(**made, response);
          forwarder_.End(made.status(), call, &Forwarder::Async::CreateMesh, request, response,
                         [reactor](const grpc::Status& end) { reactor->Finish(end); });
        };
        held.reset();
        context_.registry->FindMade(host, options, id, asking, answer);
      });
  return reactor;
}

grpc::ServerUnaryReactor* MeshServiceImpl::GetMesh(grpc::CallbackServerContext* call,
                                                   const v1::GetMeshRequest* request,
                                                   v1::Mesh* response) {
  const absl::StatusOr<Pass> pass = Admit(call, Role::kRead, request->mesh());
  if (!pass.ok()) return Finished(call, pass.status());
  auto* reactor = call->DefaultReactor();
  context_.registry->Open(
      request->mesh(), AskingOf(*call),
      [this, reactor, call, request, response](const absl::StatusOr<MeshRegistry::HostPtr>& host) {
        if (host.ok()) EncodeMesh(**host, response);
        const absl::Status status =
            host.ok() ? context_.registry->CheckRead((*host)->id()) : host.status();
        forwarder_.End(status, call, &Forwarder::Async::GetMesh, request, response,
                       [reactor](const grpc::Status& end) { reactor->Finish(end); });
      });
  return reactor;
}

grpc::ServerUnaryReactor* MeshServiceImpl::ListMeshes(grpc::CallbackServerContext* call,
                                                      const v1::ListMeshesRequest* request,
                                                      v1::ListMeshesResponse* response) {
  const absl::StatusOr<Pass> pass = Admit(call);
  if (!pass.ok()) return Finished(call, pass.status());
  if (request->page_size() < 0) {
    return Finished(call, BadRequest("page_size", "must not be negative"));
  }
  if (!request->page_token().empty() && !IsMeshId(request->page_token()) &&
      !IsRowName(request->page_token())) {
    return Finished(call, BadRequest("page_token", "is not one that this server gave"));
  }
  const int size =
      request->page_size() == 0 ? kDefaultPageSize : std::min(request->page_size(), kMaxPageSize);
  const auto count = static_cast<std::size_t>(size);
  const auto shown = [pass = *pass](absl::string_view id) { return pass.Allows(Role::kRead, id); };
  MeshRegistry* const registry = context_.registry;
  if (!registry->is_shared()) {
    EncodeList(registry->List(request->page_token(), count + 1, shown), count, response);
    return Finished(call, absl::OkStatus());
  }
  auto* reactor = call->DefaultReactor();
  context_.readers->Post([reactor, registry, request, response, shown, count] {
    const auto meshes = registry->ListAll(request->page_token(), count + 1, shown);
    if (meshes.ok()) EncodeList(*meshes, count, response);
    reactor->Finish(codec::ToGrpcStatus(meshes.status()));
  });
  return reactor;
}

grpc::ServerUnaryReactor* MeshServiceImpl::DeleteMesh(grpc::CallbackServerContext* call,
                                                      const v1::DeleteMeshRequest* request,
                                                      v1::DeleteMeshResponse* response) {
  const absl::StatusOr<Pass> pass = Admit(call, Role::kAdmin, request->mesh());
  if (!pass.ok()) return Finished(call, pass.status());
  absl::StatusOr<WorkGate::Ticket> ticket = EnterWork(context_);
  if (!ticket.ok()) return Finished(call, ticket.status());
  auto* reactor = call->DefaultReactor();
  // It may wait for the disk.
  context_.writers->Post(
      [this, reactor, call, request, response, held = *ticket,
       origin = MeshRegistry::Origin{pass->client(), CallIdOf(*call)}]() mutable {
        const absl::Status status = context_.registry->Delete(request->mesh(), origin);
        held.reset();
        forwarder_.End(status, call, &Forwarder::Async::DeleteMesh, request, response,
                       [reactor](const grpc::Status& end) { reactor->Finish(end); });
      });
  return reactor;
}

grpc::ServerUnaryReactor* MeshServiceImpl::GetStats(grpc::CallbackServerContext* call,
                                                    const v1::GetStatsRequest* request,
                                                    v1::GetStatsResponse* response) {
  // Every authenticated client may query the server's own figures.
  const absl::StatusOr<Pass> pass =
      request->mesh().empty() ? Admit(call) : Admit(call, Role::kRead, request->mesh());
  if (!pass.ok()) return Finished(call, pass.status());
  response->set_server_version(kVersion);
  const std::int64_t nanos = absl::ToInt64Nanoseconds(absl::Now() - context_.start_time);
  response->mutable_uptime()->set_seconds(nanos / 1'000'000'000);
  response->mutable_uptime()->set_nanos(static_cast<std::int32_t>(nanos % 1'000'000'000));
  response->set_meshes(context_.registry->size());
  response->set_watchers(context_.watchers.used());
  if (request->mesh().empty()) return Finished(call, absl::OkStatus());
  auto* reactor = call->DefaultReactor();
  context_.registry->Open(
      request->mesh(), AskingOf(*call),
      [this, reactor, call, request, response](const absl::StatusOr<MeshRegistry::HostPtr>& host) {
        if (host.ok()) EncodeStats(**host, response->mutable_mesh());
        const absl::Status status =
            host.ok() ? context_.registry->CheckRead((*host)->id()) : host.status();
        forwarder_.End(status, call, &Forwarder::Async::GetStats, request, response,
                       [reactor](const grpc::Status& end) { reactor->Finish(end); });
      });
  return reactor;
}

grpc::ServerUnaryReactor* MeshServiceImpl::LocatePoints(grpc::CallbackServerContext* call,
                                                        const v1::LocatePointsRequest* request,
                                                        v1::LocatePointsResponse* response) {
  const absl::StatusOr<Pass> pass = Admit(call, Role::kRead, request->mesh());
  if (!pass.ok()) return Finished(call, pass.status());
  const auto ticket = EnterWork(context_);
  if (!ticket.ok()) return Finished(call, ticket.status());
  return StartLocateCall(context_, forwarder_, *request, response, *pass, *ticket, call);
}

grpc::ServerWriteReactor<v1::MeshDiff>* MeshServiceImpl::AddFeatures(
    grpc::CallbackServerContext* call, const v1::AddFeaturesRequest* request) {
  return StartEditCall(context_, streams_, *request, Admit(call, Role::kEdit, request->mesh()),
                       call);
}

grpc::ServerWriteReactor<v1::MeshDiff>* MeshServiceImpl::RemoveFeatures(
    grpc::CallbackServerContext* call, const v1::RemoveFeaturesRequest* request) {
  return StartEditCall(context_, streams_, *request, Admit(call, Role::kEdit, request->mesh()),
                       call);
}

grpc::ServerWriteReactor<v1::MeshDiff>* MeshServiceImpl::ApplyEdits(
    grpc::CallbackServerContext* call, const v1::ApplyEditsRequest* request) {
  return StartEditCall(context_, streams_, *request, Admit(call, Role::kEdit, request->mesh()),
                       call);
}

grpc::ServerBidiReactor<Received<v1::EditBatch>, v1::MeshDiff>* MeshServiceImpl::EditStream(
    grpc::CallbackServerContext* call) {
  return StartEditStreamCall(context_, streams_, Admit(call), call);
}

grpc::ServerBidiReactor<Received<v1::LoadFeaturesRequest>, v1::LoadFeaturesResponse>*
MeshServiceImpl::LoadFeatures(grpc::CallbackServerContext* call) {
  return StartLoadCall(context_, streams_, Admit(call), call);
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* MeshServiceImpl::Watch(
    grpc::CallbackServerContext* call, const v1::WatchRequest* request) {
  return StartWatchCall(context_, *request, Admit(call, Role::kRead, request->mesh()), call);
}

grpc::ServerWriteReactor<v1::SnapshotChunk>* MeshServiceImpl::GetSnapshot(
    grpc::CallbackServerContext* call, const v1::GetSnapshotRequest* request) {
  return StartSnapshotCall(context_, *request, Admit(call, Role::kRead, request->mesh()), call);
}

grpc::ServerWriteReactor<v1::FeaturesChunk>* MeshServiceImpl::GetFeatures(
    grpc::CallbackServerContext* call, const v1::GetFeaturesRequest* request) {
  return StartFeaturesCall(context_, *request, Admit(call, Role::kRead, request->mesh()), call);
}

grpc::ServerWriteReactor<v1::MeshDiff>* MeshServiceImpl::RevertTo(
    grpc::CallbackServerContext* call, const v1::RevertToRequest* request) {
  return StartEditCall(context_, streams_, *request, Admit(call, Role::kEdit, request->mesh()),
                       call);
}

grpc::ServerBidiReactor<Received<v1::BuildMeshRequest>, v1::BuildMeshResponse>*
MeshServiceImpl::BuildMesh(grpc::CallbackServerContext* call) {
  absl::StatusOr<Pass> pass = Admit(call);
  // It costs what a batch of edits does, which a reader may not cause. There is no mesh to have the
  // role on, so any will do: a token for some meshes may cause that work there.
  if (pass.ok()) {
    if (absl::Status status = pass->CheckSome(Role::kEdit); !status.ok()) pass = status;
  }
  return StartBuildCall(context_, streams_, pass, call);
}

}  // namespace dynmesh::server
