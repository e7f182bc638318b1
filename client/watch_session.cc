#include "dynmesh/client/watch_session.h"

#include <grpcpp/alarm.h>

#include <algorithm>
#include <string>
#include <utility>

#include "client/channel_internal.h"
#include "core/base/mutex.h"
#include "proto/codec/grpc_status.h"

namespace dynmesh::client {
namespace {

class Follower;

// One Watch stream. Frees itself when gRPC is done with it.
class Stream final : public grpc::ClientReadReactor<v1::WatchEvent> {
 public:
  Stream(std::shared_ptr<Follower> follower, v1::WatchRequest request)
      : follower_(std::move(follower)), request_(std::move(request)) {}

  void Start(Stub& stub) {
    const std::string key = stub.ReadKey(request_.mesh());
    server_ = stub.Of(key);
    stub.Prepare(context_);
    call_.emplace(stub.waiting(), key, server_->address, &context_, /*is_stream=*/true);
    server_->service->async()->Watch(&context_, &request_, this);
    StartRead(&event_);
    StartCall();
  }
  void Cancel() { context_.TryCancel(); }

  void OnReadDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;

 private:
  const std::shared_ptr<Follower> follower_;
  const v1::WatchRequest request_;
  Stub::ServerPtr server_;
  grpc::ClientContext context_;
  std::optional<WaitingCalls::Call> call_;
  v1::WatchEvent event_;
};

// The state that outlives the streams: the replica, and the reconnect logic. Invariant: a stream is
// open (stream_) or about to report its end, or an alarm is set (alarm_), or the watch has ended.
class Follower : public std::enable_shared_from_this<Follower> {
 public:
  // The stub outlives Stop.
  Follower(Stub* stub, std::string mesh, const WatchOptions& options, WatchListener* listener)
      : stub_(stub),
        mesh_(std::move(mesh)),
        options_(options),
        listener_(listener != nullptr ? listener : &silent_),
        backoff_(options.first_pause, options.longest_pause) {}

  void Open() {
    const MutexLock lock(mutex_);
    OpenLocked();
  }

  // False: the stream is to be cancelled.
  bool Take(const v1::WatchEvent& event) {
    const MutexLock lock(mutex_);
    if (stopping_) return false;
    auto change = replica_.Take(event);
    if (!change.ok()) {
      trouble_ = change.status();
      changed_.NotifyAll();
      return false;
    }
    attempts_ = 0;
    backoff_.Succeeded();
    Tell(*change);
    changed_.NotifyAll();
    return true;
  }

  // The stream is about to be deleted and must not be cancelled any more. StreamEnded follows.
  void StreamGoes() {
    const MutexLock lock(mutex_);
    stream_ = nullptr;
  }

  // The next stream goes to the mesh's server.
  void Learn(const Stub::Server& asked, const absl::Status& status) {
    stub_->Learn(stub_->ReadKey(FullName(mesh_)), asked, status, /*repeatable=*/true);
  }

  void StreamEnded(const absl::Status& status) {
    const MutexLock lock(mutex_);
    replica_.EndOfStream();
    const bool gave_up = !trouble_.ok();
    const absl::Status why = gave_up ? trouble_ : status;
    trouble_ = absl::OkStatus();
    if (stopping_) return EndLocked(absl::CancelledError("the watch was stopped"));
    const bool from_snapshot = gave_up || status.code() == absl::StatusCode::kOutOfRange;
    if (!from_snapshot && !IsPassing(status)) return EndLocked(status);
    if (++attempts_ > options_.max_attempts) return EndLocked(why);
    listener_->OnTrouble(why);
    ++reconnects_;
    if (from_snapshot) {
      from_snapshot_ = true;
      if (attempts_ == 1) return OpenLocked();  // the server is available
    }
    waits_for_server_ = absl::IsUnavailable(status);
    SetAlarmLocked();
  }

  // A server that could not be reached can be.
  void ServerIsBack() {
    const MutexLock lock(mutex_);
    if (alarm_ != nullptr && waits_for_server_) alarm_->Cancel();
  }

  void Stop() {
    const MutexLock lock(mutex_);
    stopping_ = true;
    if (stream_ != nullptr) stream_->Cancel();
    if (alarm_ != nullptr) alarm_->Cancel();
    changed_.Wait(mutex_,
                  [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return ended_.has_value(); });
    listener_ = &silent_;
  }

  bool WaitFor(const std::function<bool(const MeshReplica&)>& condition, absl::Duration limit) {
    const MutexLock lock(mutex_);
    bool met = false;
    changed_.WaitFor(mutex_, Bounded(limit), [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      met = condition(replica_);
      return met || ended_.has_value();
    });
    return met;
  }

  void Read(const std::function<void(const MeshReplica&)>& reader) const {
    const MutexLock lock(mutex_);
    reader(replica_);
  }

  std::optional<absl::Status> ended() const {
    const MutexLock lock(mutex_);
    return ended_;
  }
  int resyncs() const {
    const MutexLock lock(mutex_);
    return std::max(0, snapshots_ - 1);
  }
  int reconnects() const {
    const MutexLock lock(mutex_);
    return reconnects_;
  }

 private:
  void Tell(const MeshReplica::Change& change) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (std::holds_alternative<MeshReplica::NewSnapshot>(change)) {
      ++snapshots_;
      listener_->OnSnapshot(replica_);
    } else if (const auto* diff = std::get_if<MeshDiff>(&change)) {
      listener_->OnDiff(replica_, *diff);
    } else if (std::holds_alternative<MeshReplica::Progress>(change)) {
      listener_->OnProgress(replica_);
    }
  }

  void OpenLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    v1::WatchRequest request;
    request.set_mesh(FullName(mesh_));
    request.mutable_regions()->Add(options_.regions.begin(), options_.regions.end());
    // A filtered watch always begins with a snapshot.
    if (replica_.state() == MeshReplica::State::kLive && !from_snapshot_ &&
        options_.regions.empty()) {
      request.set_start_revision(replica_.revision());
      request.set_start_hash(replica_.hash().ToHex());
    }
    from_snapshot_ = false;
    stub_->AskFollowers(&request, replica_.revision());
    const std::int64_t nanos = absl::ToInt64Nanoseconds(options_.progress_interval);
    request.mutable_progress_interval()->set_seconds(nanos / 1'000'000'000);
    request.mutable_progress_interval()->set_nanos(
        static_cast<std::int32_t>(nanos % 1'000'000'000));
    stream_ = new Stream(shared_from_this(), std::move(request));
    stream_->Start(*stub_);
  }

  void SetAlarmLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    // A new alarm each time: the previous one may still be in its callback.
    alarm_ = std::make_unique<grpc::Alarm>();
    alarm_->Set(std::chrono::system_clock::now() + absl::ToChronoNanoseconds(backoff_.Failed()),
                [self = shared_from_this()](bool) { self->AlarmFired(); });
  }

  void AlarmFired() {
    const MutexLock lock(mutex_);
    alarm_.reset();
    if (stopping_) return EndLocked(absl::CancelledError("the watch was stopped"));
    OpenLocked();
  }

  void EndLocked(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    ended_ = status;
    listener_->OnEnd(status);
    changed_.NotifyAll();
  }

  Stub* const stub_;
  const std::string mesh_;
  const WatchOptions options_;
  WatchListener silent_;

  mutable Mutex mutex_;
  CondVar changed_;
  WatchListener* listener_ ABSL_GUARDED_BY(mutex_);
  MeshReplica replica_ ABSL_GUARDED_BY(mutex_);
  Stream* stream_ ABSL_GUARDED_BY(mutex_) = nullptr;
  std::unique_ptr<grpc::Alarm> alarm_ ABSL_GUARDED_BY(mutex_);
  Backoff backoff_ ABSL_GUARDED_BY(mutex_);
  bool waits_for_server_ ABSL_GUARDED_BY(mutex_) = false;  // while an alarm is set
  int attempts_ ABSL_GUARDED_BY(mutex_) = 0;  // streams that ended since the last event
  bool from_snapshot_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status trouble_ ABSL_GUARDED_BY(mutex_);  // why the replica rejected the stream
  std::optional<absl::Status> ended_ ABSL_GUARDED_BY(mutex_);
  int snapshots_ ABSL_GUARDED_BY(mutex_) = 0;
  int reconnects_ ABSL_GUARDED_BY(mutex_) = 0;
};

void Stream::OnReadDone(bool ok) {
  if (!ok) return;  // OnDone follows
  call_->Heard(/*more=*/false);
  if (follower_->Take(event_)) {
    StartRead(&event_);
  } else {
    context_.TryCancel();
  }
}

void Stream::OnDone(const grpc::Status& status) {
  const std::shared_ptr<Follower> follower = follower_;
  const absl::Status ended = UnlessCancelledHere(codec::FromGrpcStatus(status));
  follower->Learn(*server_, ended);
  // Delete the stream before reporting its end: the receiver may drop the channel, and gRPC must
  // not release the last reference to it in one of its own threads.
  follower->StreamGoes();
  delete this;
  follower->StreamEnded(ended);
}

class GrpcWatchSession final : public WatchSession {
 public:
  GrpcWatchSession(std::shared_ptr<Stub> stub, const std::string& mesh, const WatchOptions& options,
                   WatchListener* listener)
      : stub_(std::move(stub)),
        follower_(std::make_shared<Follower>(stub_.get(), mesh, options, listener)) {
    stub_->connector().Listen(this, [follower = follower_.get()] { follower->ServerIsBack(); });
    follower_->Open();
  }
  ~GrpcWatchSession() override {
    stub_->connector().Unlisten(this);
    follower_->Stop();
  }

  void Stop() override { follower_->Stop(); }
  bool WaitFor(const std::function<bool(const MeshReplica&)>& condition,
               absl::Duration limit) override {
    return follower_->WaitFor(condition, limit);
  }
  void Read(const std::function<void(const MeshReplica&)>& reader) const override {
    follower_->Read(reader);
  }
  std::optional<absl::Status> ended() const override { return follower_->ended(); }
  int resyncs() const override { return follower_->resyncs(); }
  int reconnects() const override { return follower_->reconnects(); }

 private:
  const std::shared_ptr<Stub> stub_;
  const std::shared_ptr<Follower> follower_;
};

}  // namespace

std::unique_ptr<WatchSession> StartWatchSession(std::shared_ptr<Stub> stub, const std::string& mesh,
                                                const WatchOptions& options,
                                                WatchListener* listener) {
  return std::make_unique<GrpcWatchSession>(std::move(stub), mesh, options, listener);
}

}  // namespace dynmesh::client
