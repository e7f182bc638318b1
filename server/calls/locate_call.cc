#include "server/calls/locate_call.h"

#include <utility>

#include "proto/codec/grpc_status.h"
#include "server/calls/asking.h"
#include "server/calls/requests.h"
#include "server/calls/withdrawal.h"

namespace dynmesh::server {
namespace {

// Waits for its turn among the edits, unless it is cancelled. Frees itself.
class LocateCall final : public grpc::ServerUnaryReactor {
 public:
  LocateCall(const MeshRegistry& meshes, Forwarder& forwarder, std::string client,
             WorkGate::Ticket ticket, v1::LocatePointsResponse* response,
             grpc::CallbackServerContext* rpc)
      : meshes_(meshes),
        forwarder_(forwarder),
        client_(std::move(client)),
        ticket_(std::move(ticket)),
        response_(response),
        rpc_(rpc) {}

  // Once the mesh is open, or is not.
  void Begin(const v1::LocatePointsRequest& request,
             const absl::StatusOr<MeshRegistry::HostPtr>& host) {
    if (!host.ok()) {
      return forwarder_.End(host.status(), rpc_, &Forwarder::Async::LocatePoints, &request,
                            response_, [this](const grpc::Status& end) { Finish(end); });
    }
    absl::Status status = CheckLocate(request, (*host)->mesh_options().dimension);
    if (!status.ok()) return Finish(codec::ToGrpcStatus(status));
    may_be_old_ = request.has_min_revision();
    withdrawal_.Take(*host);
    const auto cancelled =
        withdrawal_.cancelled();  // after the submission the call may be answered and gone
    status = (*host)->Locate(
        {request.coordinates().begin(), request.coordinates().end()}, cancelled,
        [this](absl::StatusOr<MeshHost::LocateAnswer> a) { Answer(std::move(a)); }, client_);
    if (!status.ok()) return Finish(codec::ToGrpcStatus(status));
    if (cancelled->load()) (*host)->Withdraw(cancelled);
  }
  void OnCancel() override { withdrawal_.Cancel(); }
  void OnDone() override { delete this; }

 private:
  void Answer(const absl::StatusOr<MeshHost::LocateAnswer>& answer) {
    if (answer.ok()) {
      response_->set_revision(answer->revision);
      response_->mutable_simplices()->mutable_vertex_ids()->Add(answer->simplices.begin(),
                                                                answer->simplices.end());
      response_->mutable_leaf_sides()->Add(answer->leaf_sides.begin(), answer->leaf_sides.end());
    }
    ticket_.reset();
    const absl::Status read =
        may_be_old_ ? absl::OkStatus() : meshes_.CheckRead(withdrawal_.host().id());
    Finish(codec::ToGrpcStatus(answer.ok() ? read : answer.status()));
  }

  const MeshRegistry& meshes_;
  Forwarder& forwarder_;
  Withdrawal withdrawal_;
  bool may_be_old_ = false;
  const std::string client_;  // as SharingClient
  WorkGate::Ticket ticket_;
  v1::LocatePointsResponse* const response_;  // as rpc_
  grpc::CallbackServerContext* const rpc_;    // valid until the call is finished
};

}  // namespace

grpc::ServerUnaryReactor* StartLocateCall(ServiceContext& context, Forwarder& forwarder,
                                          const v1::LocatePointsRequest& request,
                                          v1::LocatePointsResponse* response, const Pass& pass,
                                          WorkGate::Ticket ticket,
                                          grpc::CallbackServerContext* rpc) {
  auto* call = new LocateCall(*context.registry, forwarder, SharingClient(context, pass),
                              std::move(ticket), response, rpc);
  context.registry->OpenToRead(request.mesh(), AskingOf(*rpc), MinRevisionOf(request),
                               [call, &request](const absl::StatusOr<MeshRegistry::HostPtr>& host) {
                                 call->Begin(request, host);
                               });
  return call;
}

}  // namespace dynmesh::server
