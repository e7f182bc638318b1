#include "server/calls/load_call.h"

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "server/base/call_id.h"
#include "server/base/log.h"
#include "server/calls/cut_call.h"
#include "server/calls/load_parts.h"
#include "server/calls/parts_call.h"

namespace dynmesh::server {
namespace {

using LoadResponse = v1::LoadFeaturesResponse;

class LoadCall final : public PartsCall<v1::LoadFeaturesRequest, v1::LoadFeaturesResponse> {
 public:
  LoadCall(ServiceContext& context, grpc::CallbackServerContext* rpc) : PartsCall(context) {
    job_.call_id = CallIdOf(*rpc);
    job_.source = EditSource::kLoad;
    job_.cancelled = cancelled_;
  }

  static LoadCall* Start(ServiceContext& context, OpenStreams& streams,
                         const absl::StatusOr<Pass>& pass, grpc::CallbackServerContext* rpc) {
    auto call = std::make_shared<LoadCall>(context, rpc);
    call->Begin(call, streams, pass, rpc);
    return call.get();
  }

  // A completely received load is the strand's: it decides how that ends.
  void OnCancel() override {
    cancelled_->store(true, std::memory_order_relaxed);
    End(WhyCut(context_, sender_, "the call was cancelled"));
    Withdraw();
  }

  void Cancel(const absl::Status& status) override {
    cancelled_->store(true, std::memory_order_relaxed);
    {
      const MutexLock lock(mutex_);
      cancel_status_ = status;
    }
    Withdraw();
  }

  void OnDone() override {
    allowed_.Close();
    PartsCall::OnDone();
  }

 private:
  // Undoes the batch if it is not done.
  void Withdraw() {
    MeshRegistry::HostPtr host;
    {
      const MutexLock lock(mutex_);
      if (phase_ == Phase::kWorking) host = host_;
    }
    if (host != nullptr) host->Withdraw(cancelled_);
  }

  bool has_begun() const override { return host_ != nullptr; }
  std::size_t features() const override { return job_.edits.size(); }
  absl::string_view IncompleteMessage() const override {
    return "the stream ended before the load's last part: nothing was applied";
  }
  LoadResponse* ProgressIn(LoadResponse* message) override { return message; }

  const std::string* MeshToOpen() override { return &request().mesh(); }

  absl::Status Receive() override {
    if (host_ == nullptr) {
      if (absl::Status s = Open(); !s.ok()) return s;
    } else if (!request().mesh().empty() && request().mesh() != mesh_name_) {
      return BadRequest("mesh", "a load is of one mesh, the one its first message names");
    }
    const v1::PointColumns& points = request().points();
    const std::size_t weight =
        static_cast<std::size_t>(points.ids_size()) + codec::Weight(request().features());
    if (absl::Status s = held_.Take(context_, pass_, weight); !s.ok()) return s;
    parts_.Add(request(), job_.edits.size());
    const int dimension = host_->mesh_options().dimension;
    if (absl::Status s = codec::DecodePointColumns(points, dimension, &job_.edits); !s.ok()) {
      return s;
    }
    return codec::DecodeAdds(request().features(), dimension, &job_.edits);
  }

  // By the first message.
  absl::Status Open() {
    if (absl::Status s = CheckRequestId(request().request_id()); !s.ok()) return s;
    absl::StatusOr<EditTarget> target =
        OpenToEdit(context_, pass_, std::move(found_), CutWhenRevoked(rpc_));
    if (!target.ok()) return target.status();
    allowed_ = std::move(target->allowed);
    place_ = std::move(target->place);
    host_ = std::move(target->host);
    mesh_name_ = request().mesh();
    job_.request_id = request().request_id();
    if (request().has_expected_revision()) job_.expected_revision = request().expected_revision();
    return absl::OkStatus();
  }

  void Submit() override {
    if (!BeginWork()) return;
    Log(LogLevel::kDebug, "load_received",
        {{"mesh", host_->id()}, {"call", job_.call_id}, {"features", job_.edits.size()}});
    Tell(LoadResponse::WAITING, 0, 0, /*now=*/true);
    job_.progress = [this, held = self_](const BatchProgress& p) {
      Tell(StageOf(p.stage), p.done, p.total);
    };
    job_.done = [this, held = self_](absl::StatusOr<EditOutcome> outcome) {
      Answer(std::move(outcome));
    };
    // Held here: after the submission the call may be gone.
    const auto held = self_;
    job_.client = SharingClient(context_, pass_);
    if (absl::Status s = host_->Apply(std::move(job_)); !s.ok()) Answer(s);
  }

  // On the strand.
  void Answer(absl::StatusOr<EditOutcome> outcome) {
    held_.Release();
    const absl::Status status = CheckRefusal(*context_.registry, *host_, outcome.status());
    bool finish = false;
    {
      const MutexLock lock(mutex_);
      const bool stopped = absl::IsCancelled(status) && !cancel_status_.ok();
      EndLocked(stopped ? cancel_status_ : status);
      if (outcome.ok()) EncodeResultLocked(*outcome);
      finish = FinishLocked();
    }
    if (finish) Close();
  }

  void EncodeResultLocked(const EditOutcome& outcome) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    v1::LoadResult& result = *result_.emplace().mutable_result();
    result.set_from_revision(outcome.diff->from_revision);
    result.set_to_revision(outcome.diff->to_revision);
    result.set_hash(outcome.diff->hash.ToHex());
    codec::EncodeWork(outcome.diff->work, result.mutable_work());
    result.set_replayed(outcome.replayed);
  }

  void Close() override {
    if (result_.has_value()) {
      sender_.Begin();
      StartWriteAndFinish(&*result_, grpc::WriteOptions(), grpc::Status::OK);
    } else {
      Finish(codec::ToGrpcStatus(parts_.Locate(final_status())));
    }
  }

  const std::shared_ptr<std::atomic<bool>> cancelled_ = std::make_shared<std::atomic<bool>>(false);

  absl::Status cancel_status_ ABSL_GUARDED_BY(mutex_);  // why the server cancelled it

  // Used by the reader, then by the strand.
  MeshRegistry::HostPtr host_;
  std::string mesh_name_;
  Access::Stream allowed_;
  EditShares held_;
  LoadParts parts_;
  EditJob job_;

  std::optional<LoadResponse> result_;  // after the work
};

}  // namespace

grpc::ServerBidiReactor<Received<v1::LoadFeaturesRequest>, v1::LoadFeaturesResponse>* StartLoadCall(
    ServiceContext& context, OpenStreams& streams, const absl::StatusOr<Pass>& pass,
    grpc::CallbackServerContext* rpc) {
  return LoadCall::Start(context, streams, pass, rpc);
}

}  // namespace dynmesh::server
