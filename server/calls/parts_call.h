// What a load and a build have in common: a call that takes features in parts, then works on
// another thread, and tells its progress meanwhile.
//
// Three threads of control: the reader, until the last part; then the work; and the writer, one
// message at a time. mutex_ guards what they share. Operations on the stream are started after it
// is released. The call ends when the reader or the work is done, and no message is being written.
#ifndef DYNMESH_SERVER_CALLS_PARTS_CALL_H_
#define DYNMESH_SERVER_CALLS_PARTS_CALL_H_

#include <grpcpp/support/server_callback.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/base/mutex.h"
#include "dynmesh/v1/mesh_service.pb.h"
#include "proto/codec/status_codec.h"
#include "server/calls/admission.h"
#include "server/calls/asking.h"
#include "server/calls/open_streams.h"
#include "server/calls/progress_stage.h"
#include "server/calls/received.h"
#include "server/calls/send_timeout.h"

namespace dynmesh::server {

template <class Request, class Response>
class PartsCall : public grpc::ServerBidiReactor<Received<Request>, Response>, public OpenStream {
 public:
  void End(const absl::Status& status) final {
    bool finish = false;
    {
      const MutexLock lock(mutex_);
      if (phase_ == Phase::kWorking) StopLocked(status);
      if (phase_ != Phase::kReceiving) return;
      EndLocked(status);
      finish = FinishLocked();
    }
    if (finish) Close();
  }

  void OnReadDone(bool ok) final {
    SetWaitsNot();
    if (ok && received_.is_parsed && !has_begun()) {
      if (const std::string* const mesh = MeshToOpen(); mesh != nullptr && MayOpen()) {
        return OpenMesh(*mesh);
      }
    }
    Handle(ok);
  }

  void Handle(bool ok) {
    const bool first = !has_begun();
    const std::size_t before = features();
    absl::Status status;
    if (ok) {
      status = received_.is_parsed ? Receive() : NotParsed(request());
    } else {
      codec::ServiceError error;
      error.reason = codec::reason::kBatchIncomplete;
      status =
          codec::MakeServiceError(absl::StatusCode::kInvalidArgument, IncompleteMessage(), error);
    }
    if (!status.ok()) return End(status);
    if (request().last()) return Submit();
    Tell(v1::LoadFeaturesResponse::RECEIVING, features(), 0);
    bool read = false;
    {
      const MutexLock lock(mutex_);
      read = phase_ == Phase::kReceiving;
    }
    // A drain may have ended it meanwhile. (The read itself does not prevent that.)
    if (read) Read(/*anew=*/first || features() > before);
  }

  void OnWriteDone(bool) override {
    bool finish = false;
    {
      const MutexLock lock(mutex_);
      writing_ = false;
      finish = FinishLocked();
    }
    if (finish) Close();
  }

  void OnDone() override {
    Leave();
    sender_.Leave();
    self_.reset();
  }

 protected:
  enum class Phase { kReceiving, kWorking, kSending, kEnded };

  explicit PartsCall(ServiceContext& context) : context_(context) {}

  // Once. `self` owns this. Begins to read, or ends with the error of `pass`.
  void Begin(std::shared_ptr<PartsCall> self, OpenStreams& streams,
             const absl::StatusOr<Pass>& pass, grpc::CallbackServerContext* rpc) {
    self_ = std::move(self);
    rpc_ = rpc;
    LimitSends(context_, rpc, sender_);
    const absl::Status status = pass.ok() ? EnterStreams(streams, *pass) : pass.status();
    if (status.ok()) {
      Read(/*anew=*/true);
    } else {
      End(status);
    }
  }

  // --- By the reader ---------------------------------------------------------------------------

  virtual bool has_begun() const = 0;        // its first message was received
  virtual std::size_t features() const = 0;  // received so far
  // The mesh of the first message, to be opened before it is received; null: there is none.
  virtual const std::string* MeshToOpen() { return nullptr; }
  virtual absl::Status Receive() = 0;  // handles the message just read
  virtual void Submit() = 0;           // after the last part: BeginWork, then the work
  virtual absl::string_view IncompleteMessage() const = 0;  // where the stream ended too early
  const Request& request() const { return received_.message; }
  // False if the call has ended meanwhile. From here on a drain waits for the work.
  bool BeginWork() {
    absl::StatusOr<WorkGate::Ticket> ticket = EnterWork(context_);
    if (!ticket.ok()) {
      End(ticket.status());
      return false;
    }
    const MutexLock lock(mutex_);
    if (phase_ != Phase::kReceiving) return false;
    phase_ = Phase::kWorking;
    ticket_ = *std::move(ticket);
    return true;
  }

  // --- By any thread ---------------------------------------------------------------------------

  // The progress of the message.
  virtual v1::LoadFeaturesResponse* ProgressIn(Response* message) = 0;
  // The call is to end while it works.
  virtual void StopLocked(const absl::Status& /*status*/) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {}
  // Sends the last message and final_status(). Once, while nothing is written.
  virtual void Close() = 0;

  // Sends progress, unless it is too early or the last message is still being written.
  void Tell(v1::LoadFeaturesResponse::Stage stage, std::uint64_t done, std::uint64_t total,
            bool now = false) {
    {
      const MutexLock lock(mutex_);
      const auto time = MetricsClock::now();
      if (writing_ || phase_ == Phase::kEnded || (!now && time - told_ < kBetweenProgress)) return;
      writing_ = true;
      told_ = time;
      v1::LoadFeaturesResponse& progress = *ProgressIn(&answer_);
      progress.set_stage(stage);
      progress.set_done(done);
      progress.set_total(total);
    }
    this->StartWrite(&answer_);
  }

  // Begins the send timeout: before, a client that does not read progress delays nothing.
  void EndLocked(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    phase_ = Phase::kEnded;
    final_status_ = status;
    sender_.Begin();
  }

  absl::Status final_status() {
    const MutexLock lock(mutex_);
    return final_status_;
  }

  // True once: the caller then has to call Close.
  bool FinishLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (phase_ != Phase::kEnded || writing_ || opening_ || finished_) return false;
    finished_ = true;
    return true;
  }

  ServiceContext& context_;
  grpc::CallbackServerContext* rpc_ = nullptr;  // from Begin until OnDone
  std::shared_ptr<PartsCall> self_;             // until OnDone

  // Used by the reader, then by the work.
  Pass pass_;
  StreamPlace place_;
  absl::StatusOr<MeshRegistry::HostPtr> found_ = MeshRegistry::HostPtr();  // the opened mesh

  Response answer_;  // used by the writer, while writing_
  OpenSends::Sender sender_;

  Mutex mutex_;
  Phase phase_ ABSL_GUARDED_BY(mutex_) = Phase::kReceiving;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status final_status_ ABSL_GUARDED_BY(mutex_);

 private:
  absl::Status EnterStreams(OpenStreams& streams, const Pass& pass) {
    pass_ = pass;
    Enter(rpc_);
    streams.Add(self_);
    // After Add: a drain either is seen here by the closed gate, or finds the stream in the list.
    return context_.gate.closed() ? DrainingError() : absl::OkStatus();
  }

  // False if the call has ended. Until the mesh is found or refused it does not finish.
  bool MayOpen() {
    const MutexLock lock(mutex_);
    opening_ = phase_ == Phase::kReceiving;
    return opening_;
  }

  void OpenMesh(const std::string& mesh) {
    const auto found = [call = self_](absl::StatusOr<MeshRegistry::HostPtr> host) {
      call->found_ = std::move(host);
      call->Handle(true);
      bool finish = false;
      {
        const MutexLock lock(call->mutex_);
        call->opening_ = false;
        finish = call->FinishLocked();
      }
      if (finish) call->Close();
    };
    const absl::Status allowed = pass_.Check(Role::kEdit, mesh);
    if (!allowed.ok()) return found(allowed);
    context_.registry->Open(mesh, AskingOf(*rpc_), found);
  }

  void Read(bool anew) {
    SetWaits(anew);
    this->StartRead(&received_);
  }

  Received<Request> received_;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  bool opening_ ABSL_GUARDED_BY(mutex_) = false;  // the mesh is being found
  MetricsClock::time_point told_ ABSL_GUARDED_BY(mutex_) = MetricsClock::now();
  WorkGate::Ticket ticket_ ABSL_GUARDED_BY(mutex_);  // until this is destroyed
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_PARTS_CALL_H_
