#include "server/calls/edit_stream_call.h"

#include <atomic>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/base/mutex.h"
#include "dynmesh/v1/status_details.pb.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "proto/codec/status_codec.h"
#include "server/base/call_id.h"
#include "server/base/log.h"
#include "server/calls/asking.h"
#include "server/calls/cut_call.h"
#include "server/calls/requests.h"
#include "server/calls/send_timeout.h"

namespace dynmesh::server {

// Three threads of control: the reader (gRPC, one message at a time), the mesh's strand, which
// answers, and the writer (gRPC, one message at a time). mutex_ guards what they share. Operations
// on the stream are started after it is released.
class EditStreamCall final : public grpc::ServerBidiReactor<Received<v1::EditBatch>, v1::MeshDiff>,
                             public OpenStream {
 public:
  EditStreamCall(ServiceContext& context, grpc::CallbackServerContext* rpc)
      : context_(context), call_id_(CallIdOf(*rpc)), rpc_(rpc) {}

  static EditStreamCall* Start(ServiceContext& context, OpenStreams& streams,
                               const absl::StatusOr<Pass>& pass, grpc::CallbackServerContext* rpc) {
    auto call = std::make_shared<EditStreamCall>(context, rpc);
    call->self_ = call;
    LimitSends(context, rpc, call->sender_);
    absl::Status status = pass.status();
    if (status.ok()) {
      call->pass_ = *pass;
      call->Enter(rpc);
      streams.Add(call);
      // After Add: a drain either is seen here by the closed gate, or finds the stream in the list.
      if (context.gate.closed()) status = DrainingError();
    }
    if (!status.ok()) {
      call->End(status);
    } else {
      call->ReadNext();
    }
    return call.get();
  }

  // Answers the completely received batches, then ends the stream.
  void End(const absl::Status& status) override {
    bool finish = false;
    {
      const MutexLock lock(mutex_);
      EndLocked(status);
      finish = FinishLocked();
    }
    if (finish) Finish(codec::ToGrpcStatus(final_status()));
  }

  void OnReadDone(bool ok) override {
    SetWaitsNot();
    // The message belongs to this thread, and to that which opens the mesh, until reading_ is
    // false.
    if (ok && received_.is_parsed && host_ == nullptr && MayOpen()) return OpenMesh();
    Handle(ok);
  }

  void Handle(bool ok) {
    if (ok) {
      absl::Status status = received_.is_parsed ? Receive() : NotParsed(request_);
      if (!status.ok()) End(status);
    } else if (partial_.has_value()) {
      codec::ServiceError error;
      error.reason = codec::reason::kBatchIncomplete;
      End(codec::MakeServiceError(absl::StatusCode::kInvalidArgument,
                                  "the stream ended inside a batch: it was not applied", error));
    }
    AfterRead(ok);
  }

  void OnWriteDone(bool ok) override {
    sender_.Done();
    bool write = false;
    bool finish = false;
    bool read = false;
    {
      const MutexLock lock(mutex_);
      if (!ok) {
        broken_ = true;
        EndLocked(WhyCut(context_, sender_, "the client disconnected"));
      }
      if (broken_ || current_->finished()) {
        context_.metrics->edits.of(EditSource::kEdit)
            .send.Observe(SecondsSince(current_->answered));
        answer_bytes_ -= current_->bytes;
        current_.reset();
        --in_flight_;
      }
      if (broken_) DropAnswersLocked();
      write = TakeAnswerLocked();
      writing_ = write;
      finish = !write && FinishLocked();
      read = !finish && ResumeReadLocked();
    }
    Continue(write, read, finish);
  }

  void OnCancel() override {
    cancelled_->store(true, std::memory_order_relaxed);
    End(WhyCut(context_, sender_, "the call was cancelled"));
    MeshRegistry::HostPtr host;
    {
      const MutexLock lock(mutex_);
      host = host_;
    }
    if (host != nullptr) host->Withdraw(cancelled_);
  }

  // Those that wait are not withdrawn, but undone in their turn: answers are in order.
  void Cancel(const absl::Status& status) override {
    {
      const MutexLock lock(mutex_);
      cancel_status_ = status;
    }
    cancelled_->store(true, std::memory_order_relaxed);
  }

  void OnDone() override {
    Leave();
    if (host_ != nullptr) {
      Log(LogLevel::kDebug, "edits_closed",
          {{"mesh", host_->id()},
           {"call", call_id_},
           {"status", absl::StatusCodeToString(final_status().code())}});
    }
    allowed_.Close();
    sender_.Leave();
    self_.reset();
  }

 private:
  // The pending answer to one batch.
  struct Answer {
    std::string request_id;
    absl::Status status;
    bool replayed = false;
    std::optional<codec::DiffFragmenter> fragmenter;
    std::size_t bytes = 0;  // of its diff
    bool status_sent = false;
    MetricsClock::time_point answered = MetricsClock::now();
    WorkGate::Ticket ticket;

    bool finished() const { return fragmenter.has_value() ? fragmenter->done() : status_sent; }
  };

  // ------------------------------------------------------------------ reading

  // Handles the message just read. An error ends the stream. An error of one batch is answered in
  // the batch's turn.
  absl::Status Receive() {
    if (ended()) return absl::OkStatus();
    if (host_ == nullptr) {
      if (absl::Status status = TakeMesh(); !status.ok()) return status;
      mesh_name_ = request_.mesh();
      stop_on_error_ = request_.stop_on_error();
      Log(LogLevel::kDebug, "edits_opened", {{"mesh", host_->id()}, {"call", call_id_}});
    } else if (!request_.mesh().empty() && request_.mesh() != mesh_name_) {
      return BadRequest("mesh", "a stream edits one mesh, the one its first message names");
    }
    brought_ = !partial_.has_value() || request_.edits_size() > 0;
    if (!partial_.has_value()) BeginBatch();
    partial_->Add(context_, pass_, request_, host_->mesh_options().dimension);
    if (!request_.more()) Submit();
    return absl::OkStatus();
  }

  // False if the stream has ended. Until the mesh is found or refused it does not finish.
  bool MayOpen() {
    const MutexLock lock(mutex_);
    opening_ = !ended_;
    return opening_;
  }

  void OpenMesh() {
    const auto found = [call = self_](absl::StatusOr<MeshRegistry::HostPtr> host) {
      call->found_ = std::move(host);
      call->Handle(true);
      bool finish = false;
      {
        const MutexLock lock(call->mutex_);
        call->opening_ = false;
        finish = call->FinishLocked();
      }
      call->Continue(false, false, finish);
    };
    const absl::Status allowed = pass_.Check(Role::kEdit, request_.mesh());
    if (!allowed.ok()) return found(allowed);
    context_.registry->Open(request_.mesh(), AskingOf(*rpc_), found);
  }

  absl::Status TakeMesh() {
    absl::StatusOr<EditTarget> target =
        OpenToEdit(context_, pass_, std::move(found_), CutWhenRevoked(rpc_));
    if (!target.ok()) return target.status();
    allowed_ = std::move(target->allowed);
    place_ = std::move(target->place);
    const MutexLock lock(mutex_);
    host_ = std::move(target->host);
    return absl::OkStatus();
  }

  void BeginBatch() {
    partial_.emplace(request_);
    EditJob& job = partial_->job;
    job.call_id = call_id_;
    job.cancelled = cancelled_;
    if (stop_on_error_) job.stop = stop_;
    job.refused.Update(pass_.TakeRequest());
    absl::StatusOr<WorkGate::Ticket> ticket = EnterWork(context_);
    if (ticket.ok()) {
      ticket_ = *std::move(ticket);
    } else {
      job.refused.Update(ticket.status());
    }
  }

  void Submit() {
    {
      const MutexLock lock(mutex_);
      // The stream ended meanwhile: a batch without an answer must not be applied.
      if (ended_) return DropPartial();
      ++in_flight_;
    }
    EditJob job = std::move(partial_->job);
    // Shared, because a std::function is copyable and leases are not.
    auto held = std::make_shared<EditShares>(std::move(partial_->held));
    job.done = [call = self_, held, omit = partial_->omit_columns, ticket = std::move(ticket_),
                request_id = job.request_id](absl::StatusOr<EditOutcome> outcome) {
      held->Release();
      Answer answer;
      answer.request_id = request_id;
      answer.status = CheckRefusal(*call->context_.registry, *call->host_, outcome.status());
      answer.ticket = ticket;
      if (outcome.ok()) {
        answer.replayed = outcome->replayed;
        answer.bytes = BytesOf(*outcome);
        answer.fragmenter.emplace(std::move(outcome->diff), omit || outcome->columns_omitted);
      }
      call->Deliver(std::move(answer));
    };
    DropPartial();
    host_->ApplyUnbounded(std::move(job));
  }

  void DropPartial() {
    partial_.reset();
    ticket_.reset();
  }

  void AfterRead(bool ok) {
    bool read = false;
    bool finish = false;
    {
      const MutexLock lock(mutex_);
      reading_ = false;
      if (!ok) ended_ = true;
      finish = FinishLocked();
      read = !finish && ResumeReadLocked();
    }
    Continue(false, read, finish);
  }

  void ReadNext() {
    {
      const MutexLock lock(mutex_);
      reading_ = true;
    }
    Read();
  }

  void Read() {
    if (host_ == nullptr || partial_.has_value()) SetWaits(/*anew=*/brought_);
    StartRead(&received_);
  }

  // ------------------------------------------------------------------ answering

  // On the strand. Starts no read. A started write, or one of gRPC's own calls of this object,
  // keeps the stream from ending meanwhile; a read does not.
  void Deliver(Answer answer) {
    bool write = false;
    bool hand_on = false;
    bool finish = false;
    {
      const MutexLock lock(mutex_);
      if (broken_ || stopped_) {
        --in_flight_;  // the client is gone, or an earlier batch ended the stream
      } else {
        if (absl::IsCancelled(answer.status) && !cancel_status_.ok()) {
          answer.status = cancel_status_;
        }
        if (!answer.status.ok() && stop_on_error_) {
          stopped_ = true;
          EndLocked(answer.status);
        }
        answer_bytes_ += answer.bytes;
        answers_.push_back(std::move(answer));
      }
      if (!writing_) {
        write = TakeAnswerLocked();
        writing_ = write;
      }
      // The mesh's next batch waits, and a write costs up to half as much as an edit.
      hand_on = write && in_flight_ > 1;
      finish = !write && FinishLocked();
    }
    if (hand_on) {
      context_.answers->Post([call = self_] { call->WriteNext(); });
    } else {
      Continue(write, /*read=*/false, finish);
    }
  }

  void WriteNext() {
    if (current_->fragmenter.has_value()) {
      current_->fragmenter->Next(&message_);
      message_.set_replayed(current_->replayed);
    } else {
      message_.Clear();
      *message_.mutable_status() = codec::StatusToProto(current_->status);
      current_->status_sent = true;
    }
    message_.set_request_id(current_->request_id);
    grpc::WriteOptions options;
    // More answers are ready: lets the transport put several small messages into one packet.
    if (more_answers_) options.set_buffer_hint();
    sender_.Begin();
    StartWrite(&message_, options);
  }

  // ------------------------------------------------------------------ with mutex_

  bool TakeAnswerLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (!current_.has_value()) {
      if (answers_.empty()) return false;
      current_.emplace(std::move(answers_.front()));
      answers_.pop_front();
    }
    more_answers_ = !answers_.empty();
    return true;
  }

  void DropAnswersLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    in_flight_ -= static_cast<int>(answers_.size());
    for (const Answer& answer : answers_) answer_bytes_ -= answer.bytes;
    answers_.clear();
  }

  void EndLocked(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (ended_) return;
    ended_ = true;
    final_status_ = status;
  }

  bool ResumeReadLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (reading_ || ended_ || in_flight_ >= context_.config.edit_window) return false;
    if (answer_bytes_ > context_.config.edit_answer_bytes) return false;
    reading_ = true;
    return true;
  }

  // True once: the caller then has to call Finish.
  bool FinishLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (!ended_ || finished_ || opening_ || in_flight_ > 0 || writing_) return false;
    finished_ = true;
    return true;
  }

  bool ended() {
    const MutexLock lock(mutex_);
    return ended_;
  }
  absl::Status final_status() {
    const MutexLock lock(mutex_);
    return final_status_;
  }

  void Continue(bool write, bool read, bool finish) {
    if (write) WriteNext();
    if (read) Read();
    if (finish) Finish(codec::ToGrpcStatus(final_status()));
  }

  ServiceContext& context_;
  const std::string call_id_;
  grpc::CallbackServerContext* const rpc_;
  Pass pass_;
  Access::Stream allowed_;                // the reader's, once there is a mesh; then until OnDone
  StreamPlace place_;                     // likewise
  std::shared_ptr<EditStreamCall> self_;  // until OnDone
  const std::shared_ptr<std::atomic<bool>> cancelled_ = std::make_shared<std::atomic<bool>>(false);
  const std::shared_ptr<std::atomic<bool>> stop_ = std::make_shared<std::atomic<bool>>(false);

  // Used by the reader.
  Received<v1::EditBatch> received_;
  v1::EditBatch& request_ = received_.message;
  absl::StatusOr<MeshRegistry::HostPtr> found_ = MeshRegistry::HostPtr();
  MeshRegistry::HostPtr host_;  // written with mutex_, for OnCancel
  std::string mesh_name_;
  bool stop_on_error_ = false;
  bool brought_ = true;                  // the last message began a batch or added edits
  std::optional<PartialBatch> partial_;  // the batch being received
  WorkGate::Ticket ticket_;              // of partial_

  // Used by the writer, while writing_.
  OpenSends::Sender sender_;
  std::optional<Answer> current_;  // the answer being written; taken with mutex_
  v1::MeshDiff message_;
  bool more_answers_ = false;

  Mutex mutex_;
  bool reading_ ABSL_GUARDED_BY(mutex_) = false;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;    // no more input is accepted
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;  // a refused batch ended the stream
  bool broken_ ABSL_GUARDED_BY(mutex_) = false;   // a write failed: the client is gone
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  bool opening_ ABSL_GUARDED_BY(mutex_) = false;        // the mesh is being found
  absl::Status cancel_status_ ABSL_GUARDED_BY(mutex_);  // why the server cancelled it
  int in_flight_ ABSL_GUARDED_BY(mutex_) = 0;  // submitted batches that are not fully answered
  absl::Status final_status_ ABSL_GUARDED_BY(mutex_);
  std::deque<Answer> answers_ ABSL_GUARDED_BY(mutex_);
  std::size_t answer_bytes_ ABSL_GUARDED_BY(mutex_) = 0;  // of these and current_
};

grpc::ServerBidiReactor<Received<v1::EditBatch>, v1::MeshDiff>* StartEditStreamCall(
    ServiceContext& context, OpenStreams& streams, const absl::StatusOr<Pass>& pass,
    grpc::CallbackServerContext* rpc) {
  return EditStreamCall::Start(context, streams, pass, rpc);
}

}  // namespace dynmesh::server
