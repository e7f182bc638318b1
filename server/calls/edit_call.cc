#include "server/calls/edit_call.h"

#include <memory>
#include <optional>
#include <utility>

#include "core/base/mutex.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "server/base/call_id.h"
#include "server/calls/asking.h"
#include "server/calls/requests.h"
#include "server/calls/send_timeout.h"
#include "server/calls/withdrawal.h"
#include "server/meshes/revert_plan.h"

namespace dynmesh::server {
namespace {

const char* EditsField(const v1::AddFeaturesRequest&) { return "features"; }
const char* EditsField(const v1::RemoveFeaturesRequest&) { return "ids"; }
const char* EditsField(const v1::ApplyEditsRequest&) { return "edits"; }
const char* EditsField(const v1::RevertToRequest&) { return "revision"; }

class EditCall final : public grpc::ServerWriteReactor<v1::MeshDiff>, public OpenStream {
 public:
  EditCall(ServiceContext& context, const char* edits_field, grpc::CallbackServerContext* rpc)
      : context_(context), edits_field_(edits_field), rpc_(rpc) {}

  template <typename Request>
  static EditCall* Start(ServiceContext& context, OpenStreams& streams, const Request& request,
                         const absl::StatusOr<Pass>& pass, grpc::CallbackServerContext* rpc) {
    auto call = std::make_shared<EditCall>(context, EditsField(request), rpc);
    call->self_ = call;
    absl::Status status = pass.status();
    if (status.ok()) {
      call->pass_ = *pass;
      call->Enter(rpc);
      streams.Add(call);
      status = call->Begin(request);
    }
    // Only before the job is submitted: after that the call may be answered and gone.
    if (!status.ok()) call->Fail(status);
    return call.get();
  }

  void OnWriteDone(bool ok) override {
    sender_.Done();
    if (ok) {
      Send();
    } else {
      Fail(WhyCut(context_, sender_, "the client disconnected"));
    }
  }
  void OnCancel() override { withdrawal_.Cancel(); }
  void End(const absl::Status& /*status*/) override {}  // it ends with its batch
  void Cancel(const absl::Status& status) override {
    {
      const MutexLock lock(end_mutex_);
      end_status_ = status;
    }
    withdrawal_.Cancel();
  }
  void OnDone() override {
    Leave();
    sender_.Leave();
    if (fragmenter_.has_value()) {
      context_.metrics->edits.of(source_).send.Observe(SecondsSince(answered_));
    }
    self_.reset();
  }

 private:
  template <typename Request>
  absl::Status Begin(const Request& request) {
    absl::StatusOr<WorkGate::Ticket> ticket = EnterWork(context_);
    if (!ticket.ok()) return ticket.status();
    ticket_ = *std::move(ticket);
    if (absl::Status s = CheckRequestId(request.request_id()); !s.ok()) return s;
    // The request lives until the call is finished.
    context_.registry->Open(request.mesh(), AskingOf(*rpc_),
                            [call = self_, &request](absl::StatusOr<MeshRegistry::HostPtr> host) {
                              const absl::Status status =
                                  host.ok() ? call->Submit(request, *std::move(host))
                                            : host.status();
                              // After a submission the call may be answered and gone.
                              if (!status.ok()) call->Fail(status);
                            });
    return absl::OkStatus();
  }

  template <typename Request>
  absl::Status Submit(const Request& request, MeshRegistry::HostPtr host) {
    withdrawal_.Take(host);
    absl::StatusOr<EditRequest> taken = TakeEditRequest(context_, pass_, std::move(host), request);
    if (!taken.ok()) return taken.status();
    taken->job.call_id = CallIdOf(*rpc_);
    omit_columns_ = request.omit_columns();
    return HandIn(request, *std::move(taken));
  }

  template <typename Request>
  absl::Status HandIn(const Request&, EditRequest taken) {
    place_ = std::move(taken.place);
    return Apply(*taken.host, std::move(taken.job));
  }

  // Holds the features of two revisions until it is done, as much memory as a snapshot.
  absl::Status HandIn(const v1::RevertToRequest& request, EditRequest taken) {
    auto place = TakePlace(context_, context_.snapshot_streams, pass_);
    if (!place.ok()) return place.status();
    snapshot_place_ = *std::move(place);
    taken.job.source = source_ = EditSource::kRevert;
    context_.readers->Post([call = self_, revision = request.revision(),
                            host = std::move(taken.host), job = std::move(taken.job)]() mutable {
      RevertPlan plan = PlanRevert(*host, revision, call->withdrawal_.cancelled());
      job.make = std::move(plan.job.make);
      job.content = plan.job.content;
      job.expected_hash = plan.job.expected_hash;
      auto room = TakeEdits(call->context_, call->pass_, 0, plan.weight);
      absl::Status status = room.status();
      if (status.ok()) {
        call->place_ = *std::move(room);
        status = call->Apply(*host, std::move(job));
      }
      if (!status.ok()) call->Fail(status);
    });
    return absl::OkStatus();
  }

  absl::Status Apply(MeshHost& host, EditJob job) {
    job.client = SharingClient(context_, pass_);
    job.cancelled = withdrawal_.cancelled();
    job.done = [call = self_](absl::StatusOr<EditOutcome> outcome) {
      call->Answer(std::move(outcome));
    };
    return host.Apply(std::move(job));
  }

  void Answer(absl::StatusOr<EditOutcome> outcome) {
    place_ = {};
    snapshot_place_ = {};
    if (!outcome.ok()) {
      return Fail(CheckRefusal(*context_.registry, withdrawal_.host(), outcome.status()));
    }
    answered_ = MetricsClock::now();
    LimitSends(context_, rpc_, sender_);
    replayed_ = outcome->replayed;
    fragmenter_.emplace(std::move(outcome->diff), omit_columns_ || outcome->columns_omitted);
    Send();
  }

  void Send() {
    fragmenter_->Next(&message_);
    message_.set_replayed(replayed_);
    sender_.Begin();
    if (fragmenter_->done()) {
      StartWriteAndFinish(&message_, grpc::WriteOptions(), grpc::Status::OK);
    } else {
      StartWrite(&message_);
    }
  }

  void Fail(absl::Status status) {
    if (absl::IsCancelled(status)) {
      const MutexLock lock(end_mutex_);
      if (!end_status_.ok()) status = end_status_;
    }
    Finish(codec::ToGrpcStatus(status, edits_field_));
  }

  ServiceContext& context_;
  const char* const edits_field_;
  grpc::CallbackServerContext* const rpc_;  // until OnDone
  OpenSends::Sender sender_;
  MetricsClock::time_point answered_;
  EditSource source_ = EditSource::kEdit;
  Withdrawal withdrawal_;
  Mutex end_mutex_;
  absl::Status end_status_ ABSL_GUARDED_BY(end_mutex_);  // why the server cancelled it
  std::shared_ptr<EditCall> self_;                       // until OnDone
  WorkGate::Ticket ticket_;
  Pass pass_;
  SharedLimit::Place place_;
  SharedLimit::Place snapshot_place_;
  bool omit_columns_ = false;
  bool replayed_ = false;
  std::optional<codec::DiffFragmenter> fragmenter_;
  v1::MeshDiff message_;
};

}  // namespace

grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context, OpenStreams& streams,
                                                      const v1::AddFeaturesRequest& request,
                                                      const absl::StatusOr<Pass>& pass,
                                                      grpc::CallbackServerContext* rpc) {
  return EditCall::Start(context, streams, request, pass, rpc);
}
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context, OpenStreams& streams,
                                                      const v1::RemoveFeaturesRequest& request,
                                                      const absl::StatusOr<Pass>& pass,
                                                      grpc::CallbackServerContext* rpc) {
  return EditCall::Start(context, streams, request, pass, rpc);
}
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context, OpenStreams& streams,
                                                      const v1::ApplyEditsRequest& request,
                                                      const absl::StatusOr<Pass>& pass,
                                                      grpc::CallbackServerContext* rpc) {
  return EditCall::Start(context, streams, request, pass, rpc);
}
grpc::ServerWriteReactor<v1::MeshDiff>* StartEditCall(ServiceContext& context, OpenStreams& streams,
                                                      const v1::RevertToRequest& request,
                                                      const absl::StatusOr<Pass>& pass,
                                                      grpc::CallbackServerContext* rpc) {
  return EditCall::Start(context, streams, request, pass, rpc);
}

}  // namespace dynmesh::server
