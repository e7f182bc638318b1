#include "server/calls/build_call.h"

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "server/base/call_id.h"
#include "server/calls/build_request.h"
#include "server/calls/parts_call.h"

namespace dynmesh::server {
namespace {

class BuildCall final : public PartsCall<v1::BuildMeshRequest, v1::BuildMeshResponse> {
 public:
  explicit BuildCall(ServiceContext& context) : PartsCall(context) {}

  static BuildCall* Start(ServiceContext& context, OpenStreams& streams,
                          const absl::StatusOr<Pass>& pass, grpc::CallbackServerContext* rpc) {
    auto call = std::make_shared<BuildCall>(context);
    call->call_id_ = CallIdOf(*rpc);
    const bool can_build = context.build_pool != nullptr && context.build_pool->can_build();
    if (can_build || !pass.ok()) {
      call->Begin(call, streams, pass, rpc);
    } else {
      call->Begin(call, streams, absl::UnimplementedError("this server builds no meshes"), rpc);
    }
    return call.get();
  }

  void OnWriteDone(bool ok) override {
    bool send = false, finish = false;
    {
      const MutexLock lock(mutex_);
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

 private:
  bool has_begun() const override { return request_.has_begun(); }
  std::size_t features() const override { return request_.features(); }
  absl::string_view IncompleteMessage() const override {
    return "the stream ended before the build's last part";
  }
  v1::LoadFeaturesResponse* ProgressIn(v1::BuildMeshResponse* message) override {
    return message->mutable_progress();
  }
  // A mesh that is there is sent.
  void StopLocked(const absl::Status& status) override ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (!stop_status_.ok()) return;
    stop_status_ = status;
    stopped_->store(true, std::memory_order_relaxed);
  }

  absl::Status Receive() override {
    if (!request_.has_begun()) {
      absl::StatusOr<StreamPlace> place = TakeStream(context_, context_.builds, pass_);
      if (!place.ok()) return place.status();
      place_ = *std::move(place);
    }
    return request_.Add(context_, pass_, request());
  }

  void Submit() override {
    if (!BeginWork()) return;
    BuildJob job = request_.TakeJob();
    job.call_id = call_id_;
    job.stopped = stopped_;
    job.progress = [this, held = self_](const BatchProgress& p) {
      Tell(StageOf(p.stage), p.done, p.total);
    };
    job.done = [this, held = self_](absl::StatusOr<Mesh> mesh) { Answer(std::move(mesh)); };
    context_.build_pool->Post(std::move(job));
  }

  // On the build's thread.
  void Answer(absl::StatusOr<Mesh> mesh) {
    request_.Release();
    bool send = false, finish = false;
    {
      const MutexLock lock(mutex_);
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

  void Close() override { Finish(codec::ToGrpcStatus(request_.Locate(final_status()))); }

  const std::shared_ptr<std::atomic<bool>> stopped_ = std::make_shared<std::atomic<bool>>(false);
  std::string call_id_;
  BuildRequest request_;                             // used by the reader, then by the build
  std::optional<codec::SnapshotFragmenter> chunks_;  // used by the writer, in Phase::kSending
  absl::Status stop_status_;                         // why the build is stopped
};

}  // namespace

grpc::ServerBidiReactor<Received<v1::BuildMeshRequest>, v1::BuildMeshResponse>* StartBuildCall(
    ServiceContext& context, OpenStreams& streams, const absl::StatusOr<Pass>& pass,
    grpc::CallbackServerContext* rpc) {
  return BuildCall::Start(context, streams, pass, rpc);
}

}  // namespace dynmesh::server
