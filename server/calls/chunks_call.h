// Base of the calls that stream a state of a mesh, chunk by chunk at the client's pace.
#ifndef DYNMESH_SERVER_CALLS_CHUNKS_CALL_H_
#define DYNMESH_SERVER_CALLS_CHUNKS_CALL_H_

#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <memory>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "proto/codec/grpc_status.h"
#include "server/calls/admission.h"
#include "server/calls/asking.h"
#include "server/calls/send_timeout.h"
#include "server/calls/withdrawal.h"

namespace dynmesh::server {

// `Call` derives from this. Its Begin(context, request, host) either returns an error or ensures
// that Stream or Fail is called once, on any thread. A call frees itself.
template <class Call, class Chunk, class Fragmenter>
class ChunksCall : public grpc::ServerWriteReactor<Chunk> {
 public:
  template <class Request>
  static Call* Start(ServiceContext& context, const Request& request,
                     const absl::StatusOr<Pass>& pass, grpc::CallbackServerContext* rpc) {
    auto call = std::make_shared<Call>();
    call->self_ = call;
    call->context_ = &context;
    LimitSends(context, rpc, call->sender_);
    absl::Status status = pass.status();
    if (status.ok()) {
      call->pass_ = *pass;
      status = call->Enter();
    }
    if (!status.ok()) {
      call->Fail(status);
      return call.get();
    }
    call->may_be_old_ = request.has_min_revision();
    // The request lives until the call is finished.
    context.registry->OpenToRead(
        request.mesh(), AskingOf(*rpc), MinRevisionOf(request),
        [call, &context, &request](absl::StatusOr<MeshRegistry::HostPtr> host) {
          absl::Status begun = call->Take(host);
          if (begun.ok()) begun = call->Begin(context, request, *host);
          if (!begun.ok()) call->Fail(begun);
        });
    return call.get();
  }

  void OnWriteDone(bool ok) override {
    sender_.Done();
    if (ok) {
      Send();
    } else {
      Fail(WhyCut(*context_, sender_, "the client disconnected"));
    }
  }
  void OnCancel() override { withdrawal_.Cancel(); }
  void OnDone() override {
    sender_.Leave();
    self_.reset();
  }

 protected:
  template <class... Arguments>
  void Stream(Arguments&&... arguments) {
    fragmenter_.emplace(std::forward<Arguments>(arguments)...);
    Send();
  }
  void Fail(const absl::Status& status) { this->Finish(codec::ToGrpcStatus(status)); }

  const std::shared_ptr<Call>& self() const { return self_; }
  std::shared_ptr<const std::atomic<bool>> cancelled() const { return withdrawal_.cancelled(); }

  // A state of the mesh was read that is to be the present one, unless the request says otherwise.
  absl::Status CheckRead(const MeshHost& host) const {
    if (may_be_old_) return absl::OkStatus();
    return context_->registry->CheckRead(host.id());
  }

 private:
  absl::Status Enter() {
    absl::StatusOr<WorkGate::Ticket> ticket = EnterWork(*context_);
    if (!ticket.ok()) return ticket.status();
    ticket_ = *std::move(ticket);
    return absl::OkStatus();
  }
  // The number of concurrent states is limited.
  absl::Status Take(const absl::StatusOr<MeshRegistry::HostPtr>& host) {
    if (!host.ok()) return host.status();
    absl::StatusOr<StreamPlace> place = TakeStream(*context_, context_->snapshot_streams, pass_);
    if (!place.ok()) return place.status();
    place_ = *std::move(place);
    withdrawal_.Take(*host);
    return absl::OkStatus();
  }
  void Send() {
    fragmenter_->Next(&chunk_);
    sender_.Begin();
    if (fragmenter_->done()) {
      this->StartWriteAndFinish(&chunk_, grpc::WriteOptions(), grpc::Status::OK);
    } else {
      this->StartWrite(&chunk_);
    }
  }

  std::shared_ptr<Call> self_;  // until OnDone
  ServiceContext* context_ = nullptr;
  bool may_be_old_ = false;
  OpenSends::Sender sender_;
  Withdrawal withdrawal_;
  Pass pass_;
  WorkGate::Ticket ticket_;
  StreamPlace place_;
  std::optional<Fragmenter> fragmenter_;
  Chunk chunk_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_CHUNKS_CALL_H_
