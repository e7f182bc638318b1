#include "server/calls/watch_call.h"

#include <grpcpp/server_context.h>

#include <atomic>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/base/mutex.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "proto/codec/status_codec.h"
#include "server/base/log.h"
#include "server/calls/asking.h"
#include "server/calls/cut_call.h"
#include "server/calls/requests.h"
#include "server/calls/send_timeout.h"
#include "server/calls/shared_events.h"
#include "server/meshes/watch_filter.h"

namespace dynmesh::server {
namespace {

// A client that reads nothing leaves a few of these in the server: one prepared, one in gRPC. A
// smaller size costs some microseconds more per fragment.
constexpr std::size_t kFragmentBytes = 64'000;

// Exactly one party drives the call at a time. Pump hands it to the hub (idle), to the pool (work)
// or to gRPC (a write), so no lock is needed.
class WatchCall final : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  static WatchCall* Start(ServiceContext& context, const v1::WatchRequest& request,
                          const absl::StatusOr<Pass>& pass, grpc::CallbackServerContext* rpc) {
    auto call = std::make_shared<WatchCall>();
    call->self_ = call;
    call->context_ = &context;
    LimitSends(context, rpc, call->sender_);
    absl::Status status = pass.status();
    if (status.ok() && context.gate.closed()) status = DrainingError();
    if (!status.ok()) {
      call->Finish(codec::ToGrpcStatus(status));
      return call.get();
    }
    call->pass_ = *pass;
    // The request lives until the call is finished.
    context.registry->OpenToRead(
        request.mesh(), AskingOf(*rpc), MinRevisionOf(request),
        [call, &request, rpc](const absl::StatusOr<MeshRegistry::HostPtr>& host) {
          call->Opened(request, host, rpc);
        });
    return call.get();
  }

  void OnSendInitialMetadataDone(bool ok) override { Continue(ok); }
  void OnWriteDone(bool ok) override {
    sender_.Done();
    bytes_.Clear();
    // Clear keeps a message's memory, so after a diff of many fragments the message is replaced.
    if (std::exchange(was_last_of_many_, false)) event_ = v1::WatchEvent();
    Continue(ok);
  }
  void OnCancel() override {
    std::shared_ptr<Subscription> subscription;
    {
      const MutexLock lock(mutex_);
      cancelled_ = true;
      subscription = subscription_;
    }
    cut_->store(true);
    if (subscription != nullptr && subscription->Cancel())
      Finish(codec::ToGrpcStatus(WhyCut(*context_, sender_, "the client disconnected")));
  }
  void OnDone() override {
    allowed_.Close();
    sender_.Leave();
    if (subscription_ != nullptr) {
      subscription_->Cancel();
      Log(LogLevel::kDebug, "watch_closed", {{"mesh", mesh_}});
    }
    self_.reset();
  }

 private:
  void Opened(const v1::WatchRequest& request, const absl::StatusOr<MeshRegistry::HostPtr>& host,
              grpc::CallbackServerContext* rpc) {
    absl::Status status = host.status();
    if (status.ok()) status = Prepare(request);
    if (status.ok()) status = Begin(*host, rpc);
    if (!Is(status, codec::reason::kCompacted)) return Begun(status);
    // The server does not hold that revision any more, but the journal may.
    auto place = TakePlace(*context_, context_->pasts, pass_);
    if (!place.ok()) return Begun(status);
    past_place_ = *std::move(place);
    context_->registry->MakePast(
        *host, start_, cut_,
        [call = self_, host = *host, rpc, status](absl::StatusOr<MeshRegistry::Past> past) mutable {
          call->past_place_ = {};
          if (Is(past.status(), codec::reason::kDiverged)) status = past.status();
          call->Begun(past.ok() ? call->BeginAfter(*std::move(past), host, rpc) : status);
        });
  }

  void Begun(const absl::Status& status) {
    if (!status.ok()) {
      Finish(codec::ToGrpcStatus(status));
    } else {
      // Shows the client that the watch is set up, though no event may come for long.
      StartSendInitialMetadata();
    }
  }

  static bool Is(const absl::Status& status, absl::string_view reason) {
    const auto error = codec::GetServiceError(status);
    return error.has_value() && error->reason == reason;
  }

  absl::Status Prepare(const v1::WatchRequest& request) {
    absl::StatusOr<WatchHub::Start> start = DecodeStart(request);
    if (!start.ok()) return start.status();
    start_ = *std::move(start);
    absl::StatusOr<mesh_data::RegionChoice> regions = DecodeRegions(request.regions());
    if (!regions.ok()) return regions.status();
    if (!regions->IsEverything()) filter_.emplace(*std::move(regions));
    absl::StatusOr<StreamPlace> place = TakeStream(*context_, context_->watchers, pass_);
    if (!place.ok()) return place.status();
    place_ = *std::move(place);
    return absl::OkStatus();
  }

  // These diffs first, then what follows them.
  absl::Status BeginAfter(MeshRegistry::Past past, const MeshRegistry::HostPtr& host,
                          grpc::CallbackServerContext* rpc) {
    start_.revision = past.back()->to_revision;
    start_.hash = past.back()->hash;
    past_.assign(past.begin(), past.end());
    return Begin(host, rpc);
  }

  absl::Status Begin(const MeshRegistry::HostPtr& host, grpc::CallbackServerContext* rpc) {
    // The hub outlives a running wake-up; this call may not.
    const auto wake = [weak = std::weak_ptr<WatchCall>(self_)] {
      if (const auto call = weak.lock()) call->Pump();
    };
    auto subscription = host->hub()->Subscribe(start_, wake);
    if (!subscription.ok()) return subscription.status();
    {
      const MutexLock lock(mutex_);
      if (cancelled_) {
        (*subscription)->Cancel();
        return absl::CancelledError("the client disconnected");
      }
      subscription_ = *subscription;
    }
    mesh_ = host->id();
    absl::StatusOr<Access::Stream> allowed =
        context_->access->Open(pass_, Role::kRead, mesh_, CutWhenRevoked(rpc));
    if (!allowed.ok()) return allowed.status();
    allowed_ = *std::move(allowed);
    Log(LogLevel::kDebug, "watch_opened", {{"mesh", mesh_}, {"watchers", host->hub()->size()}});
    return absl::OkStatus();
  }

  void Continue(bool ok) {
    if (ok) {
      Pump();
    } else {
      Finish(codec::ToGrpcStatus(WhyCut(*context_, sender_, "the client disconnected")));
    }
  }

  void Pump() {
    if (SendFragment()) return;
    WatchItem item;
    if (!past_.empty()) {
      item = std::move(past_.front());
      past_.pop_front();
      return Send(std::move(item));
    }
    switch (subscription_->Next(&item)) {
      case Subscription::Step::kItem:
        return Send(std::move(item));
      case Subscription::Step::kIdle:
        return;  // another thread may drive already: touch nothing
      case Subscription::Step::kWork:
        context_->readers->Post([call = self_] { call->Send(call->subscription_->Work()); });
        return;
    }
  }

  void Send(WatchItem item) {
    if (filter_.has_value() && !Filter(item)) return;
    if (auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&item)) {
      snapshot_.emplace(std::move(*mesh), kFragmentBytes);
    } else if (auto* diff = std::get_if<std::shared_ptr<const MeshDiff>>(&item)) {
      // A filtered diff is this watch's own.
      if (!filter_.has_value()) shared_ = context_->events.Find(*diff, kFragmentBytes);
      if (shared_ == nullptr) {
        diff_.emplace(std::move(*diff), /*omit_columns=*/false, kFragmentBytes);
      }
    } else if (const auto* head = std::get_if<Head>(&item)) {
      event_.mutable_progress()->set_revision(head->revision);
      event_.mutable_progress()->set_hash(head->hash.ToHex());
      Write();
      return;
    } else {
      Finish(codec::ToGrpcStatus(std::get<absl::Status>(item)));
      return;
    }
    SendFragment();
  }

  // False if the watch ends. A filtered mesh is a copy, while all watchers share one whole mesh. So
  // the number of filtered ones counts against the limit of snapshots.
  bool Filter(WatchItem& item) {
    if (std::holds_alternative<std::shared_ptr<const Mesh>>(item)) {
      auto place = TakePlace(*context_, context_->snapshot_streams, pass_);
      if (!place.ok()) {
        Finish(codec::ToGrpcStatus(place.status()));
        return false;
      }
      snapshot_place_ = *std::move(place);
    }
    item = filter_->Apply(item);
    return true;
  }

  // False if no mesh or diff is being sent.
  bool SendFragment() {
    if (shared_ != nullptr) {
      bytes_ = (*shared_)[next_shared_];
      if (++next_shared_ == shared_->size()) {
        next_shared_ = 0;
        shared_.reset();
      }
      WriteBytes();
      return true;
    }
    if (snapshot_.has_value() && snapshot_->Next(event_.mutable_snapshot())) {
      if (snapshot_->done()) {
        was_last_of_many_ = true;
        snapshot_.reset();  // releases the mesh before waiting
        snapshot_place_ = {};
      }
    } else if (diff_.has_value() && diff_->Next(event_.mutable_diff())) {
      if (diff_->done()) {
        was_last_of_many_ = is_of_many_;
        is_of_many_ = false;
        diff_.reset();
      } else {
        is_of_many_ = true;
      }
    } else {
      return false;
    }
    Write();
    return true;
  }

  void Write() {
    bytes_ = EncodeEvent(event_);
    WriteBytes();
  }
  void WriteBytes() {
    sender_.Begin();
    StartWrite(&bytes_);
  }

  std::shared_ptr<WatchCall> self_;  // until OnDone
  ServiceContext* context_ = nullptr;
  OpenSends::Sender sender_;
  Pass pass_;
  StreamPlace place_;
  SharedLimit::Place past_place_;  // while its past is made
  std::string mesh_;               // for the log
  Access::Stream allowed_;
  Mutex mutex_;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  const std::shared_ptr<std::atomic<bool>> cut_ = std::make_shared<std::atomic<bool>>(false);
  WatchHub::Start start_;
  // To be sent before what the hub has.
  std::deque<std::shared_ptr<const MeshDiff>> past_;
  std::shared_ptr<Subscription> subscription_;  // written with mutex_, for OnCancel
  std::optional<WatchFilter> filter_;
  SharedLimit::Place snapshot_place_;  // of a filtered snapshot being sent
  std::optional<codec::SnapshotFragmenter> snapshot_;
  std::optional<codec::DiffFragmenter> diff_;
  // The diff being sent, if watches share it.
  std::shared_ptr<const SharedEvents::Events> shared_;
  std::size_t next_shared_ = 0;
  v1::WatchEvent event_;
  grpc::ByteBuffer bytes_;  // the message being sent
  // The diff being sent has more than one fragment.
  bool is_of_many_ = false;
  // `event_` holds the last of several fragments.
  bool was_last_of_many_ = false;
};

}  // namespace

grpc::ServerWriteReactor<grpc::ByteBuffer>* StartWatchCall(ServiceContext& context,
                                                           const v1::WatchRequest& request,
                                                           const absl::StatusOr<Pass>& pass,
                                                           grpc::CallbackServerContext* rpc) {
  return WatchCall::Start(context, request, pass, rpc);
}

}  // namespace dynmesh::server
