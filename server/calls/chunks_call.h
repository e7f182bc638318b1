// Base of the calls that stream a state of a mesh, chunk by chunk at the client's pace.
#ifndef DYNMESH_SERVER_CALLS_CHUNKS_CALL_H_
#define DYNMESH_SERVER_CALLS_CHUNKS_CALL_H_

#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "proto/codec/grpc_status.h"
#include "server/calls/admission.h"
#include "server/calls/send_timeout.h"

namespace dynmesh::server {

// `Call` derives from this. Its Begin(context, request) either returns an error or ensures that
// Stream or Fail is called once, on any thread. A call frees itself.
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
      status = call->Begin(context, request);
    }
    if (!status.ok()) call->Fail(status);
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
  void OnCancel() override {
    cancelled_->store(true, std::memory_order_relaxed);
    if (host_ != nullptr) host_->Withdraw(cancelled_);
  }
  void OnDone() override {
    sender_.Leave();
    self_.reset();
  }

 protected:
  // Checks of all such calls: the mesh must exist, and the number of concurrent states is limited.
  absl::StatusOr<MeshRegistry::HostPtr> Enter(ServiceContext& context, const std::string& mesh) {
    absl::StatusOr<WorkGate::Ticket> ticket = EnterWork(context);
    if (!ticket.ok()) return ticket.status();
    ticket_ = *std::move(ticket);
    absl::StatusOr<MeshRegistry::HostPtr> host = context.registry->Find(mesh);
    if (!host.ok()) return host.status();
    absl::StatusOr<StreamPlace> place =
        TakeStream(context, context.snapshot_streams, "concurrent snapshots", pass_);
    if (!place.ok()) return place.status();
    place_ = *std::move(place);
    host_ = *host;
    return host;
  }
  template <class... Arguments>
  void Stream(Arguments&&... arguments) {
    fragmenter_.emplace(std::forward<Arguments>(arguments)...);
    Send();
  }
  void Fail(const absl::Status& status) { this->Finish(codec::ToGrpcStatus(status)); }

  const std::shared_ptr<Call>& self() const { return self_; }
  std::shared_ptr<const std::atomic<bool>> cancelled() const { return cancelled_; }

 private:
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
  OpenSends::Sender sender_;
  const std::shared_ptr<std::atomic<bool>> cancelled_ = std::make_shared<std::atomic<bool>>(false);
  Pass pass_;
  WorkGate::Ticket ticket_;
  StreamPlace place_;
  MeshRegistry::HostPtr host_;  // set before OnCancel can be called
  std::optional<Fragmenter> fragmenter_;
  Chunk chunk_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_CHUNKS_CALL_H_
