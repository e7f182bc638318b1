#include "server/calls/edit_call.h"

#include <atomic>
#include <memory>
#include <optional>
#include <utility>

#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "server/meshes/revert_plan.h"

namespace dynmesh::server {
namespace {

absl::Status Decode(const v1::AddFeaturesRequest& r, int dimension, EditBatch* out) {
  return codec::DecodeAdds(r.features(), dimension, out);
}
absl::Status Decode(const v1::RemoveFeaturesRequest& r, int, EditBatch* out) {
  for (const FeatureId id : r.ids()) out->push_back(Edit::Remove(id));
  return absl::OkStatus();
}
absl::Status Decode(const v1::ApplyEditsRequest& r, int dimension, EditBatch* out) {
  return codec::DecodeEdits(r.edits(), dimension, out);
}

const char* EditsField(const v1::AddFeaturesRequest&) { return "features"; }
const char* EditsField(const v1::RemoveFeaturesRequest&) { return "ids"; }
const char* EditsField(const v1::ApplyEditsRequest&) { return "edits"; }
const char* EditsField(const v1::RevertToRequest&) { return "revision"; }

std::size_t Weight(const v1::AddFeaturesRequest& r) { return codec::Weight(r.features()); }
std::size_t Weight(const v1::RemoveFeaturesRequest& r) {
  return static_cast<std::size_t>(r.ids_size());
}
std::size_t Weight(const v1::ApplyEditsRequest& r) { return codec::Weight(r.edits()); }

class EditCall final : public grpc::ServerWriteReactor<v1::MeshDiff> {
 public:
  EditCall(const char* edits_field, Histogram& send_seconds)
      : edits_field_(edits_field), send_seconds_(send_seconds) {}

  template <typename Request>
  static EditCall* Start(ServiceContext& context, const Request& request,
                         const absl::Status& admitted, std::string call_id) {
    auto call =
        std::make_shared<EditCall>(EditsField(request), context.metrics->edits.send_seconds);
    call->self_ = call;
    const absl::Status status =
        admitted.ok() ? call->Begin(context, request, std::move(call_id)) : admitted;
    // Not after a job was handed in: it may have been answered, and the call be gone.
    if (!status.ok()) call->Fail(status);
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
  void OnDone() override {
    if (fragmenter_.has_value()) send_seconds_.Observe(SecondsSince(answered_));
    self_.reset();
  }

 private:
  template <typename Request>
  absl::Status Begin(ServiceContext& context, const Request& request, std::string call_id) {
    absl::StatusOr<WorkGate::Ticket> ticket = EnterWork(context);
    if (!ticket.ok()) return ticket.status();
    ticket_ = *std::move(ticket);
    if (absl::Status s = CheckRequestId(request.request_id()); !s.ok()) return s;
    absl::StatusOr<MeshRegistry::HostPtr> host = context.registry->Find(request.mesh());
    if (!host.ok()) return host.status();
    EditJob job;
    job.call_id = std::move(call_id);
    job.request_id = request.request_id();
    if (request.has_expected_revision()) job.expected_revision = request.expected_revision();
    omit_columns_ = request.omit_columns();
    return HandIn(context, request, *std::move(host), std::move(job));
  }

  template <typename Request>
  absl::Status HandIn(ServiceContext& context, const Request& request, MeshRegistry::HostPtr host,
                      EditJob job) {
    absl::StatusOr<Lease> lease = TakeEdits(context, 0, Weight(request));
    if (!lease.ok()) return lease.status();
    lease_ = *std::move(lease);
    const int dimension = host->mesh_options().dimension;
    if (absl::Status s = Decode(request, dimension, &job.edits); !s.ok()) return s;
    job.validate_only = request.validate_only();
    return Apply(*host, std::move(job));
  }

  // Features of two revisions are held until it is done, as much as a snapshot.
  absl::Status HandIn(ServiceContext& context, const v1::RevertToRequest& request,
                      MeshRegistry::HostPtr host, EditJob job) {
    absl::StatusOr<Lease> lease = TakeStream(context.snapshot_streams, "snapshots under way");
    if (!lease.ok()) return lease.status();
    snapshot_lease_ = *std::move(lease);
    context.readers->Post([call = self_, &context, revision = request.revision(),
                           host = std::move(host), job = std::move(job)]() mutable {
      RevertPlan plan = PlanRevert(*host, revision, call->cancelled_);
      job.make = std::move(plan.job.make);
      job.content = plan.job.content;
      job.expected_hash = plan.job.expected_hash;
      absl::StatusOr<Lease> room = TakeEdits(context, 0, plan.weight);
      absl::Status status = room.status();
      if (status.ok()) {
        call->lease_ = *std::move(room);
        status = call->Apply(*host, std::move(job));
      }
      if (!status.ok()) call->Fail(status);
    });
    return absl::OkStatus();
  }

  absl::Status Apply(MeshHost& host, EditJob job) {
    job.cancelled = cancelled_;
    job.done = [call = self_](absl::StatusOr<EditOutcome> outcome) {
      call->Answer(std::move(outcome));
    };
    return host.Apply(std::move(job));
  }

  void Answer(absl::StatusOr<EditOutcome> outcome) {
    lease_.Release();
    snapshot_lease_.Release();
    if (!outcome.ok()) return Fail(outcome.status());
    answered_ = MetricsClock::now();
    replayed_ = outcome->replayed;
    fragmenter_.emplace(std::move(outcome->diff), omit_columns_ || outcome->columns_omitted);
    Send();
  }

  void Send() {
    fragmenter_->Next(&message_);
    message_.set_replayed(replayed_);
    if (fragmenter_->done()) {
      StartWriteAndFinish(&message_, grpc::WriteOptions(), grpc::Status::OK);
    } else {
      StartWrite(&message_);
    }
  }

  void Fail(const absl::Status& status) { Finish(codec::ToGrpcStatus(status, edits_field_)); }

  const char* const edits_field_;
  Histogram& send_seconds_;
  MetricsClock::time_point answered_;
  const std::shared_ptr<std::atomic<bool>> cancelled_ = std::make_shared<std::atomic<bool>>(false);
  std::shared_ptr<EditCall> self_;  // until OnDone
  WorkGate::Ticket ticket_;
  Lease lease_;
  Lease snapshot_lease_;
  bool omit_columns_ = false;
  bool replayed_ = false;
  std::optional<codec::DiffFragmenter> fragmenter_;
  v1::MeshDiff message_;
};

}  // namespace

grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::AddFeaturesRequest& request,
                                                      const absl::Status& admitted,
                                                      std::string call_id) {
  return EditCall::Start(context, request, admitted, std::move(call_id));
}
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::RemoveFeaturesRequest& request,
                                                      const absl::Status& admitted,
                                                      std::string call_id) {
  return EditCall::Start(context, request, admitted, std::move(call_id));
}
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::ApplyEditsRequest& request,
                                                      const absl::Status& admitted,
                                                      std::string call_id) {
  return EditCall::Start(context, request, admitted, std::move(call_id));
}
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context,
                                                      const v1::RevertToRequest& request,
                                                      const absl::Status& admitted,
                                                      std::string call_id) {
  return EditCall::Start(context, request, admitted, std::move(call_id));
}

}  // namespace dynmesh::server
