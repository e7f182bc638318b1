#include "server/calls/load_call.h"

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "proto/codec/status_codec.h"
#include "server/base/call_id.h"
#include "server/base/log.h"
#include "server/calls/load_parts.h"
#include "server/calls/progress_stage.h"
#include "server/calls/send_timeout.h"

namespace dynmesh::server {
namespace {

using Response = v1::LoadFeaturesResponse;

// Three threads of control: the reader, until the last part; then the mesh's strand; and the
// writer, one message at a time. mutex_ guards what they share. Operations on the stream are
// started after it is released. The call ends when the reader or the strand is done and no message
// is being written.
class LoadCall final
    : public grpc::ServerBidiReactor<Received<v1::LoadFeaturesRequest>, v1::LoadFeaturesResponse>,
      public OpenStream {
 public:
  LoadCall(ServiceContext& context, grpc::CallbackServerContext* rpc)
      : context_(context), rpc_(rpc) {
    job_.call_id = CallIdOf(*rpc);
    job_.source = EditSource::kLoad;
    job_.cancelled = cancelled_;
  }

  static LoadCall* Start(ServiceContext& context, OpenStreams& streams,
                         const absl::StatusOr<Pass>& pass, grpc::CallbackServerContext* rpc) {
    auto call = std::make_shared<LoadCall>(context, rpc);
    call->self_ = call;
    LimitSends(context, rpc, call->sender_);
    const absl::Status status = pass.ok() ? call->Enter(streams, *pass) : pass.status();
    if (status.ok()) {
      call->Read(/*anew=*/true);
    } else {
      call->End(status);
    }
    return call.get();
  }

  // Has no effect on a completely received load: the strand decides how it ends.
  void End(const absl::Status& status) override {
    bool finish = false;
    {
      const std::lock_guard lock(mutex_);
      if (phase_ != Phase::kReceiving) return;
      EndLocked(status);
      finish = FinishLocked();
    }
    if (finish) Close();
  }

  void OnReadDone(bool ok) override {
    SetWaitsNot();
    const bool first = host_ == nullptr;
    const std::size_t edits = job_.edits.size();
    absl::Status status;
    if (ok) {
      status = received_.is_parsed ? Receive() : NotParsed(request_);
    } else {
      codec::ServiceError error;
      error.reason = codec::reason::kBatchIncomplete;
      status = codec::MakeServiceError(
          absl::StatusCode::kInvalidArgument,
          "the stream ended before the load's last part: nothing was applied", error);
    }
    if (!status.ok()) return End(status);
    if (request_.last()) return Submit();
    Tell(Response::RECEIVING, job_.edits.size(), 0);
    bool read = false;
    {
      const std::lock_guard lock(mutex_);
      read = phase_ == Phase::kReceiving;
    }
    // A drain may have ended it meanwhile. (The read itself does not prevent that.)
    if (!read) return;
    Read(/*anew=*/first || job_.edits.size() > edits);
  }

  void OnWriteDone(bool) override {
    bool finish = false;
    {
      const std::lock_guard lock(mutex_);
      writing_ = false;
      finish = FinishLocked();
    }
    if (finish) Close();
  }

  void OnCancel() override {
    cancelled_->store(true, std::memory_order_relaxed);
    End(WhyCut(context_, sender_, "the call was cancelled"));
    MeshRegistry::HostPtr host;
    {
      const std::lock_guard lock(mutex_);
      if (phase_ == Phase::kSubmitted) host = host_;
    }
    if (host != nullptr) host->Withdraw(cancelled_);
  }

  void OnDone() override {
    allowed_.Close();
    sender_.Leave();
    self_.reset();
  }

 private:
  enum class Phase { kReceiving, kSubmitted, kEnded };

  absl::Status Enter(OpenStreams& streams, const Pass& pass) {
    pass_ = pass;
    streams.Add(self_);
    // After Add: a drain either is seen here by the closed gate, or finds the stream in the list.
    return context_.gate.closed() ? DrainingError() : absl::OkStatus();
  }

  void Read(bool anew) {
    SetWaits(anew);
    StartRead(&received_);
  }

  // Handles the message just read.
  absl::Status Receive() {
    if (host_ == nullptr) {
      if (absl::Status s = Begin(); !s.ok()) return s;
    } else if (!request_.mesh().empty() && request_.mesh() != mesh_name_) {
      return BadRequest("mesh", "a load is of one mesh, the one its first message names");
    }
    const v1::PointColumns& points = request_.points();
    const std::size_t weight =
        static_cast<std::size_t>(points.ids_size()) + codec::Weight(request_.features());
    if (absl::Status s = held_.Take(context_, weight); !s.ok()) return s;
    parts_.Add(request_, job_.edits.size());
    const int dimension = host_->mesh_options().dimension;
    if (absl::Status s = codec::DecodePointColumns(points, dimension, &job_.edits); !s.ok()) {
      return s;
    }
    return codec::DecodeAdds(request_.features(), dimension, &job_.edits);
  }

  absl::Status Begin() {
    if (absl::Status s = CheckRequestId(request_.request_id()); !s.ok()) return s;
    absl::StatusOr<EditTarget> target =
        OpenToEdit(context_, pass_, request_.mesh(), [rpc = rpc_] { rpc->TryCancel(); });
    if (!target.ok()) return target.status();
    allowed_ = std::move(target->allowed);
    place_ = std::move(target->place);
    host_ = std::move(target->host);
    mesh_name_ = request_.mesh();
    job_.request_id = request_.request_id();
    if (request_.has_expected_revision()) job_.expected_revision = request_.expected_revision();
    return absl::OkStatus();
  }

  // After the last part. From here on a drain waits for the load.
  void Submit() {
    absl::StatusOr<WorkGate::Ticket> ticket = EnterWork(context_);
    if (!ticket.ok()) return End(ticket.status());
    {
      const std::lock_guard lock(mutex_);
      if (phase_ != Phase::kReceiving) return;  // ended meanwhile: it must not be applied
      phase_ = Phase::kSubmitted;
      ticket_ = *std::move(ticket);
    }
    Log(LogLevel::kDebug, "load_received",
        {{"mesh", host_->id()}, {"call", job_.call_id}, {"features", job_.edits.size()}});
    Tell(Response::WAITING, 0, 0, /*now=*/true);
    job_.progress = [call = self_](const BatchProgress& p) {
      call->Tell(StageOf(p.stage), p.done, p.total);
    };
    job_.done = [call = self_](absl::StatusOr<EditOutcome> outcome) {
      call->Answer(std::move(outcome));
    };
    // Held here: after the submission the call may be gone.
    const auto call = self_;
    if (absl::Status s = host_->Apply(std::move(job_)); !s.ok()) call->Answer(s);
  }

  // On the strand.
  void Answer(absl::StatusOr<EditOutcome> outcome) {
    held_.Release();
    bool finish = false;
    {
      const std::lock_guard lock(mutex_);
      EndLocked(outcome.status());
      if (outcome.ok()) EncodeResultLocked(*outcome);
      finish = FinishLocked();
    }
    if (finish) Close();
  }

  void EncodeResultLocked(const EditOutcome& outcome) {
    v1::LoadResult& result = *result_.emplace().mutable_result();
    result.set_from_revision(outcome.diff->from_revision);
    result.set_to_revision(outcome.diff->to_revision);
    result.set_hash(outcome.diff->hash.ToHex());
    codec::EncodeWork(outcome.diff->work, result.mutable_work());
    result.set_replayed(outcome.replayed);
  }

  // Sends progress, unless it is too early or the last message is still being written.
  void Tell(Response::Stage stage, std::uint64_t done, std::uint64_t total, bool now = false) {
    {
      const std::lock_guard lock(mutex_);
      const auto time = MetricsClock::now();
      if (writing_ || phase_ == Phase::kEnded || (!now && time - told_ < kBetweenProgress)) return;
      writing_ = true;
      told_ = time;
      progress_.set_stage(stage);
      progress_.set_done(done);
      progress_.set_total(total);
    }
    StartWrite(&progress_);
  }

  // Begins the send timeout: before, a client that does not read progress delays nothing.
  void EndLocked(const absl::Status& status) {
    phase_ = Phase::kEnded;
    final_status_ = status;
    sender_.Begin();
  }

  // True once: the caller then has to call Close.
  bool FinishLocked() {
    if (phase_ != Phase::kEnded || writing_ || finished_) return false;
    finished_ = true;
    return true;
  }

  void Close() {
    if (result_.has_value()) {
      sender_.Begin();
      StartWriteAndFinish(&*result_, grpc::WriteOptions(), grpc::Status::OK);
    } else {
      Finish(codec::ToGrpcStatus(parts_.Locate(final_status_)));
    }
  }

  ServiceContext& context_;
  grpc::CallbackServerContext* const rpc_;
  std::shared_ptr<LoadCall> self_;  // until OnDone
  const std::shared_ptr<std::atomic<bool>> cancelled_ = std::make_shared<std::atomic<bool>>(false);

  // Used by the reader, then by the strand.
  Pass pass_;
  Received<v1::LoadFeaturesRequest> received_;
  v1::LoadFeaturesRequest& request_ = received_.message;
  MeshRegistry::HostPtr host_;
  std::string mesh_name_;
  Access::Stream allowed_;
  StreamPlace place_;
  HeldEdits held_;
  LoadParts parts_;
  EditJob job_;

  Response progress_;  // used by the writer, while writing_
  OpenSends::Sender sender_;

  std::mutex mutex_;
  Phase phase_ = Phase::kReceiving;
  bool writing_ = false;
  bool finished_ = false;
  MetricsClock::time_point told_ = MetricsClock::now();
  WorkGate::Ticket ticket_;
  absl::Status final_status_;
  std::optional<Response> result_;
};

}  // namespace

grpc::ServerBidiReactor<Received<v1::LoadFeaturesRequest>, v1::LoadFeaturesResponse>* StartLoadCall(
    ServiceContext& context, OpenStreams& streams, const absl::StatusOr<Pass>& pass,
    grpc::CallbackServerContext* rpc) {
  return LoadCall::Start(context, streams, pass, rpc);
}

}  // namespace dynmesh::server
