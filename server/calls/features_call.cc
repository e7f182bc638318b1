#include "server/calls/features_call.h"

#include <atomic>
#include <memory>
#include <optional>
#include <utility>

#include "proto/codec/features_codec.h"
#include "proto/codec/grpc_status.h"

namespace dynmesh::server {
namespace {

class FeaturesCall final : public grpc::ServerWriteReactor<v1::FeaturesChunk> {
 public:
  static FeaturesCall* Start(ServiceContext& context, const v1::GetFeaturesRequest& request,
                             const absl::Status& admitted) {
    auto call = std::make_shared<FeaturesCall>();
    call->self_ = call;
    const absl::Status status = admitted.ok() ? call->Begin(context, request) : admitted;
    if (!status.ok()) call->Finish(codec::ToGrpcStatus(status));
    return call.get();
  }

  void OnWriteDone(bool ok) override {
    if (ok) {
      Send();
    } else {
      Finish(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
    }
  }
  void OnCancel() override { cancelled_->store(true, std::memory_order_relaxed); }
  void OnDone() override { self_.reset(); }

 private:
  absl::Status Begin(ServiceContext& context, const v1::GetFeaturesRequest& request) {
    absl::StatusOr<WorkGate::Ticket> ticket = EnterWork(context);
    if (!ticket.ok()) return ticket.status();
    ticket_ = *std::move(ticket);
    absl::StatusOr<MeshRegistry::HostPtr> host = context.registry->Find(request.mesh());
    if (!host.ok()) return host.status();
    absl::StatusOr<Lease> lease = TakeStream(context.snapshot_streams, "snapshots under way");
    if (!lease.ok()) return lease.status();
    lease_ = *std::move(lease);
    std::optional<std::uint64_t> revision;
    if (request.has_revision()) revision = request.revision();
    const int dimension = (*host)->mesh_options().dimension;
    return (*host)->Features(revision, cancelled_,
                             [call = self_, dimension](absl::StatusOr<codec::FeaturesAt> found) {
                               if (!found.ok())
                                 return call->Finish(codec::ToGrpcStatus(found.status()));
                               call->fragmenter_.emplace(*std::move(found), dimension);
                               call->Send();
                             });
  }

  void Send() {
    fragmenter_->Next(&chunk_);
    if (fragmenter_->done()) {
      StartWriteAndFinish(&chunk_, grpc::WriteOptions(), grpc::Status::OK);
    } else {
      StartWrite(&chunk_);
    }
  }

  std::shared_ptr<FeaturesCall> self_;  // until OnDone
  const std::shared_ptr<std::atomic<bool>> cancelled_ = std::make_shared<std::atomic<bool>>(false);
  WorkGate::Ticket ticket_;
  Lease lease_;
  std::optional<codec::FeaturesFragmenter> fragmenter_;
  v1::FeaturesChunk chunk_;
};

}  // namespace

grpc::ServerWriteReactor<v1::FeaturesChunk>* StartFeaturesCall(
    ServiceContext& context, const v1::GetFeaturesRequest& request, const absl::Status& admitted) {
  return FeaturesCall::Start(context, request, admitted);
}

}  // namespace dynmesh::server
