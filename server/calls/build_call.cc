#include "server/calls/build_call.h"

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "proto/codec/status_codec.h"
#include "server/base/call_id.h"
#include "server/calls/build_request.h"
#include "server/calls/progress_stage.h"
#include "server/calls/send_timeout.h"

namespace dynmesh::server {
namespace {

using Request = v1::BuildMeshRequest;
using Response = v1::BuildMeshResponse;
using Stage = v1::LoadFeaturesResponse::Stage;

// Three threads of control: the reader, until the last part; then the build; and the writer, one
// message at a time. mutex_ guards what they share. Operations on the stream are started after it
// is released. The call ends when the reader or the build has failed, or the mesh is sent, and no
// message is being written.
class BuildCall final : public grpc::ServerBidiReactor<Received<Request>, Response>,
                        public OpenStream {
 public:
  explicit BuildCall(ServiceContext& context) : context_(context) {}

  static BuildCall* Start(ServiceContext& context, OpenStreams& streams,
                          const absl::StatusOr<Pass>& pass, grpc::CallbackServerContext* rpc) {
    auto call = std::make_shared<BuildCall>(context);
    call->self_ = call;
    call->call_id_ = CallIdOf(*rpc);
    LimitSends(context, rpc, call->sender_);
    const absl::Status status = pass.ok() ? call->Enter(streams, *pass) : pass.status();
    if (status.ok()) {
      call->Read(/*anew=*/true);
    } else {
      call->End(status);
    }
    return call.get();
  }

  // Stops a build. A mesh that is there is sent.
  void End(const absl::Status& status) override {
    bool finish = false;
    {
      const std::lock_guard lock(mutex_);
      if (phase_ == Phase::kBuilding && stop_status_.ok()) {
        stop_status_ = status;
        stopped_->store(true, std::memory_order_relaxed);
      }
      if (phase_ != Phase::kReceiving) return;
      EndLocked(status);
      finish = FinishLocked();
    }
    if (finish) Close();
  }

  void OnReadDone(bool ok) override {
    SetWaitsNot();
    const bool first = !request_.has_begun();
    const std::size_t features = request_.features();
    absl::Status status;
    if (ok) {
      status = received_.is_parsed ? Receive() : NotParsed(received_.message);
    } else {
      codec::ServiceError error;
      error.reason = codec::reason::kBatchIncomplete;
      status = codec::MakeServiceError(absl::StatusCode::kInvalidArgument,
                                       "the stream ended before the build's last part", error);
    }
    if (!status.ok()) return End(status);
    if (received_.message.last()) return Submit();
    Tell(v1::LoadFeaturesResponse::RECEIVING, request_.features(), 0);
    bool read = false;
    {
      const std::lock_guard lock(mutex_);
      read = phase_ == Phase::kReceiving;
    }
    if (read) Read(/*anew=*/first || request_.features() > features);
  }

  void OnWriteDone(bool ok) override {
    bool send = false, finish = false;
    {
      const std::lock_guard lock(mutex_);
      writing_ = false;
      if (phase_ == Phase::kSending && !ok) {
        EndLocked(WhyCut(context_, sender_, "the client disconnected"));
      }
      send = writing_ = phase_ == Phase::kSending;
      finish = FinishLocked();
    }
    if (send) Send();
    if (finish) Close();
  }

  void OnCancel() override { End(WhyCut(context_, sender_, "the call was cancelled")); }

  void OnDone() override {
    sender_.Leave();
    self_.reset();
  }

 private:
  enum class Phase { kReceiving, kBuilding, kSending, kEnded };

  absl::Status Enter(OpenStreams& streams, const Pass& pass) {
    if (context_.build_pool == nullptr || !context_.build_pool->can_build()) {
      return absl::UnimplementedError("this server builds no meshes");
    }
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
    if (!request_.has_begun()) {
      absl::StatusOr<StreamPlace> place =
          TakeStream(context_, context_.builds, "concurrent builds", pass_);
      if (!place.ok()) return place.status();
      place_ = *std::move(place);
    }
    return request_.Add(context_, received_.message);
  }

  // After the last part.
  void Submit() {
    absl::StatusOr<WorkGate::Ticket> ticket = EnterWork(context_);
    if (!ticket.ok()) return End(ticket.status());
    BuildJob job = request_.TakeJob();
    job.call_id = call_id_;
    job.stopped = stopped_;
    job.progress = [call = self_](const BatchProgress& p) {
      call->Tell(StageOf(p.stage), p.done, p.total);
    };
    job.done = [call = self_](absl::StatusOr<Mesh> mesh) { call->Answer(std::move(mesh)); };
    {
      const std::lock_guard lock(mutex_);
      if (phase_ != Phase::kReceiving) return;  // ended meanwhile
      phase_ = Phase::kBuilding;
      ticket_ = *std::move(ticket);
    }
    context_.build_pool->Post(std::move(job));
  }

  // On the build's thread.
  void Answer(absl::StatusOr<Mesh> mesh) {
    request_.Release();
    bool send = false, finish = false;
    {
      const std::lock_guard lock(mutex_);
      if (mesh.ok()) {
        chunks_.emplace(std::make_shared<const Mesh>(*std::move(mesh)));
        phase_ = Phase::kSending;
        // Begins the send timeout, as EndLocked does.
        sender_.Begin();
        send = !std::exchange(writing_, true);
      } else {
        EndLocked(stop_status_.ok() ? mesh.status() : stop_status_);
        finish = FinishLocked();
      }
    }
    if (send) Send();
    if (finish) Close();
  }

  // The next chunk. The caller has set writing_.
  void Send() {
    sender_.Done();
    chunks_->Next(answer_.mutable_mesh());
    sender_.Begin();
    if (chunks_->done()) {
      StartWriteAndFinish(&answer_, grpc::WriteOptions(), grpc::Status::OK);
    } else {
      StartWrite(&answer_);
    }
  }

  // Sends progress, unless it is too early or the last message is still being written.
  void Tell(Stage stage, std::uint64_t done, std::uint64_t total) {
    {
      const std::lock_guard lock(mutex_);
      const auto time = MetricsClock::now();
      if (writing_ || phase_ == Phase::kEnded || time - told_ < kBetweenProgress) return;
      writing_ = true;
      told_ = time;
      v1::LoadFeaturesResponse& progress = *answer_.mutable_progress();
      progress.set_stage(stage);
      progress.set_done(done);
      progress.set_total(total);
    }
    StartWrite(&answer_);
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

  void Close() { Finish(codec::ToGrpcStatus(request_.Locate(final_status_))); }

  ServiceContext& context_;
  std::shared_ptr<BuildCall> self_;  // until OnDone
  const std::shared_ptr<std::atomic<bool>> stopped_ = std::make_shared<std::atomic<bool>>(false);
  std::string call_id_;

  // Used by the reader, then by the build.
  Pass pass_;
  Received<Request> received_;
  StreamPlace place_;
  BuildRequest request_;

  Response answer_;                                  // used by the writer, while writing_
  std::optional<codec::SnapshotFragmenter> chunks_;  // the same, in Phase::kSending
  OpenSends::Sender sender_;

  std::mutex mutex_;
  Phase phase_ = Phase::kReceiving;
  bool writing_ = false;
  bool finished_ = false;
  MetricsClock::time_point told_ = MetricsClock::now();
  WorkGate::Ticket ticket_;
  absl::Status stop_status_;  // why the build is stopped
  absl::Status final_status_;
};

}  // namespace

grpc::ServerBidiReactor<Received<Request>, Response>* StartBuildCall(
    ServiceContext& context, OpenStreams& streams, const absl::StatusOr<Pass>& pass,
    grpc::CallbackServerContext* rpc) {
  return BuildCall::Start(context, streams, pass, rpc);
}

}  // namespace dynmesh::server
