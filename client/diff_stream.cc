#include "dynmesh/client/diff_stream.h"

#include <algorithm>
#include <deque>
#include <thread>
#include <utility>

#include "client/channel_internal.h"
#include "core/base/mutex.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"

namespace dynmesh::client {
namespace {

constexpr std::size_t kAhead = 16;  // revisions read ahead
constexpr absl::Duration kFirstPause = absl::Milliseconds(50), kLongestPause = absl::Seconds(2);

class GrpcDiffStream final : public DiffStream {
 public:
  GrpcDiffStream(std::shared_ptr<Stub> stub, const std::string& mesh,
                 const DiffStreamOptions& options)
      : stub_(std::move(stub)),
        mesh_(FullName(mesh)),
        options_(options),
        revision_(options.start_revision),
        hash_(options.start_hash),
        reader_([this] { Run(); }) {
    stub_->connector().Listen(this, [this] { ServerIsBack(); });
  }
  ~GrpcDiffStream() override {
    stub_->connector().Unlisten(this);
    Cancel();
    reader_.join();
  }

  absl::StatusOr<std::optional<Event>> Next(absl::Duration limit) override {
    const MutexLock lock(mutex_);
    changed_.WaitFor(mutex_, Bounded(limit), [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return !events_.empty() || ended_.has_value() || cancelled_;
    });
    if (cancelled_) return absl::CancelledError("the stream was cancelled");
    if (!events_.empty()) {
      std::optional<Event> event(std::move(events_.front()));
      events_.pop_front();
      changed_.NotifyAll();
      return event;
    }
    if (ended_.has_value()) return *ended_;
    return std::optional<Event>();
  }

  void Cancel() override {
    const MutexLock lock(mutex_);
    cancelled_ = true;
    if (context_ != nullptr) context_->TryCancel();
    changed_.NotifyAll();
  }

 private:
  void Run() {
    of_reader_.AssertHeld();
    Backoff backoff(kFirstPause, kLongestPause);
    absl::Time last_sign = absl::Now();
    for (;;) {
      const std::uint64_t revision_before = revision_;
      const absl::Status status = ReadStream();
      if (revision_ != revision_before || heard_) last_sign = absl::Now(), backoff.Succeeded();
      const MutexLock lock(mutex_);
      if (cancelled_) return;
      if (status.code() == absl::StatusCode::kOutOfRange && options_.takes_snapshots &&
          !from_snapshot_) {
        from_snapshot_ = true;
        continue;
      }
      if (!IsPassing(status) || absl::Now() - last_sign > options_.patience) {
        ended_ = status.ok() ? absl::UnavailableError("the stream ended again and again") : status;
        changed_.NotifyAll();
        return;
      }
      const bool waits_for_server = absl::IsUnavailable(status);
      server_is_back_ = false;
      changed_.WaitFor(mutex_, absl::ToChronoNanoseconds(backoff.Failed()),
                       [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
                         return cancelled_ || (waits_for_server && server_is_back_);
                       });
      if (cancelled_) return;
    }
  }

  // A server that could not be reached can be.
  void ServerIsBack() {
    const MutexLock lock(mutex_);
    server_is_back_ = true;
    changed_.NotifyAll();
  }

  // One Watch call, until it ends.
  absl::Status ReadStream() ABSL_EXCLUSIVE_LOCKS_REQUIRED(of_reader_) {
    v1::WatchRequest request;
    request.set_mesh(mesh_);
    if (!from_snapshot_) {
      request.set_start_revision(revision_);
      request.set_start_hash(hash_.ToHex());
    }
    stub_->AskFollowers(&request, revision_);
    grpc::ClientContext context;
    stub_->Prepare(context);
    {
      const MutexLock lock(mutex_);
      if (cancelled_) return absl::CancelledError("the stream was cancelled");
      context_ = &context;
    }
    heard_ = false;
    const std::string key = stub_->ReadKey(mesh_);
    const Stub::ServerPtr server = stub_->Of(key);
    WaitingCalls::Call call(stub_->waiting(), key, server->address, &context, /*is_stream=*/true);
    auto stream = server->service->Watch(&context, request);
    codec::SnapshotAssembler snapshot;
    codec::DiffAssembler diff;
    absl::Status broken;
    v1::WatchEvent event;
    while (broken.ok() && stream->Read(&event)) {
      heard_ = true;
      call.Heard(/*more=*/false);
      if (event.has_snapshot()) {
        auto whole = snapshot.Add(event.snapshot());
        broken = whole.status();
        if (whole.ok() && whole->has_value()) Hand(Event(**std::move(whole)));
      } else if (event.has_diff()) {
        auto whole = diff.Add(event.diff());
        broken = whole.status();
        if (!whole.ok() || !whole->has_value()) continue;
        if ((*whole)->from_revision != revision_) {
          broken = absl::InternalError("a revision is missing in the stream");
        } else {
          Hand(Event(**std::move(whole)));
        }
      }
    }
    if (!broken.ok()) context.TryCancel();
    const absl::Status status = UnlessCancelledHere(codec::FromGrpcStatus(stream->Finish()));
    stub_->Learn(key, *server, status, /*repeatable=*/true);
    const MutexLock lock(mutex_);
    context_ = nullptr;
    return broken.ok() ? status : broken;
  }

  // Blocks until there is room.
  void Hand(Event event) ABSL_EXCLUSIVE_LOCKS_REQUIRED(of_reader_) {
    const MutexLock lock(mutex_);
    changed_.Wait(mutex_, [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return events_.size() < kAhead || cancelled_;
    });
    from_snapshot_ = false;
    if (const auto* diff = std::get_if<MeshDiff>(&event)) {
      revision_ = diff->to_revision, hash_ = diff->hash;
    } else {
      revision_ = std::get<Mesh>(event).revision, hash_ = std::get<Mesh>(event).hash;
    }
    events_.push_back(std::move(event));
    changed_.NotifyAll();
  }

  const std::shared_ptr<Stub> stub_;
  const std::string mesh_;
  const DiffStreamOptions options_;

  Mutex mutex_;
  CondVar changed_;
  std::deque<Event> events_ ABSL_GUARDED_BY(mutex_);
  std::optional<absl::Status> ended_ ABSL_GUARDED_BY(mutex_);
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  bool server_is_back_ ABSL_GUARDED_BY(mutex_) = false;
  grpc::ClientContext* context_ ABSL_GUARDED_BY(mutex_) = nullptr;  // of the running call

  ThreadRole of_reader_;  // the part of reader_
  std::uint64_t revision_ ABSL_GUARDED_BY(of_reader_);
  MeshHash hash_ ABSL_GUARDED_BY(of_reader_);
  bool from_snapshot_ ABSL_GUARDED_BY(of_reader_) = false;
  bool heard_ ABSL_GUARDED_BY(of_reader_) = false;  // the last call received an event
  std::thread reader_;                              // last member: it uses the others
};

}  // namespace

std::unique_ptr<DiffStream> StartDiffStream(std::shared_ptr<Stub> stub, const std::string& mesh,
                                            const DiffStreamOptions& options) {
  return std::make_unique<GrpcDiffStream>(std::move(stub), mesh, options);
}

}  // namespace dynmesh::client
