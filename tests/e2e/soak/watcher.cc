#include "tests/e2e/soak/watcher.h"

#include <grpcpp/grpcpp.h>

#include <chrono>

#include "absl/strings/str_cat.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::soak {

Watcher::Watcher(const Config& config, std::shared_ptr<grpc::Channel> channel, WatchCounts* counts,
                 Faults* faults)
    : config_(config),
      stub_(v1::MeshService::NewStub(channel)),
      counts_(counts),
      faults_(faults),
      random_(config.seed) {
  if (config.replica) replica_.emplace();
}

void Watcher::Run() {
  while (!Done()) FollowOnce();
}

void Watcher::Close(std::uint64_t last_revision) {
  last_ = last_revision;
  closing_.Notify();
}

void Watcher::Abandon() {
  abandoned_ = true;
  const std::lock_guard lock(mutex_);
  if (context_ != nullptr) context_->TryCancel();
}

bool Watcher::Has(std::uint64_t last_revision, const std::string& hash) const {
  return check_.revision() == last_revision && check_.hash() == hash &&
         (!replica_.has_value() ||
          (replica_->revision() == last_revision && replica_->hash().ToHex() == hash));
}

v1::WatchRequest Watcher::Request() const {
  v1::WatchRequest request;
  request.set_mesh("meshes/" + config_.mesh);
  // Short, since a watcher that has the last revision already must be released.
  request.mutable_progress_interval()->set_seconds(1);
  if (check_.revision().has_value()) {
    request.set_start_revision(*check_.revision());
    request.set_start_hash(check_.hash());
  }
  return request;
}

void Watcher::FollowOnce() {
  grpc::ClientContext context;
  bool planned = false;
  if (config_.manner == Manner::kRestless && !closing_.HasBeenNotified()) {
    planned = true;
    std::exponential_distribution<double> seconds(1 / absl::ToDoubleSeconds(4 * config_.nap));
    context.set_deadline(std::chrono::system_clock::now() +
                         absl::ToChronoMilliseconds(absl::Seconds(0.01 + seconds(random_))));
  }
  {
    const std::lock_guard lock(mutex_);
    context_ = &context;
    if (abandoned_) context.TryCancel();
  }
  blamed_ = false;
  const auto reader = stub_->Watch(&context, Request());
  v1::WatchEvent event;
  while (reader->Read(&event) && Take(event) && !Done()) {
    if (config_.manner == Manner::kSlow) Nap(config_.nap);
  }
  if (blamed_ || Done()) context.TryCancel();
  while (reader->Read(&event)) {
  }
  const absl::Status status = codec::FromGrpcStatus(reader->Finish());
  {
    const std::lock_guard lock(mutex_);
    context_ = nullptr;
  }
  check_.EndOfStream();
  if (replica_.has_value()) replica_->EndOfStream();
  if (!blamed_ && !Done()) Ended(status, planned);
}

bool Watcher::Take(const v1::WatchEvent& event) {
  const bool first = !check_.revision().has_value();
  const auto step = check_.Take(event);
  if (!step.ok()) {
    Blame(step.status());
    return false;
  }
  if (replica_.has_value()) {
    const absl::Status taken = replica_->Take(event).status();
    // A replica verifies each revision by its hash; here the revision numbers are compared as well.
    const bool same =
        *step == RevisionCheck::Step::kPart ||
        (replica_->revision() == check_.revision() && replica_->hash().ToHex() == check_.hash());
    if (!taken.ok() || !same) {
      Blame(taken.ok() ? absl::DataLossError("the replica differs") : taken);
      return false;
    }
  }
  switch (*step) {
    case RevisionCheck::Step::kRevision:
      ++counts_->revisions;
      break;
    case RevisionCheck::Step::kCoalesced:
      ++counts_->coalesced;
      break;
    case RevisionCheck::Step::kSnapshot:
      counts_->resyncs += first ? 0 : 1;
      break;
    case RevisionCheck::Step::kPart:
    case RevisionCheck::Step::kProgress:
      break;
  }
  if (check_.revision().has_value()) revision_ = *check_.revision();
  return true;
}

void Watcher::Ended(const absl::Status& status, bool planned) {
  if (planned && absl::IsDeadlineExceeded(status)) {
    ++counts_->reconnects;
    return Nap(config_.nap);
  }
  const auto error = codec::GetServiceError(status);
  if (error.has_value() && error->reason == codec::reason::kCompacted) {
    ++counts_->compacted;
    check_.Forget();
    return;
  }
  ++counts_->broken;
  faults_->Add(absl::StrCat("a watch of ", config_.mesh, " ended: ", status.ToString()));
  closing_.WaitForNotificationWithTimeout(absl::Milliseconds(200));
}

void Watcher::Blame(const absl::Status& status) {
  blamed_ = true;
  auto& count = absl::IsOutOfRange(status)      ? counts_->lost
                : absl::IsAlreadyExists(status) ? counts_->doubled
                                                : counts_->damaged;
  ++count;
  faults_->Add(absl::StrCat("a watcher of ", config_.mesh, ": ", status.ToString()));
  check_.Forget();  // begins anew
  if (replica_.has_value()) replica_.emplace();
}

void Watcher::Nap(absl::Duration mean) {
  std::exponential_distribution<double> part(1);
  // Now and then a long one.
  const double times = part(random_) * (random_() % 64 == 0 ? 20 : 1);
  closing_.WaitForNotificationWithTimeout(mean * times);
}

SessionWatcher::SessionWatcher(std::string mesh, client::MeshClient& client, WatchCounts* counts,
                               Faults* faults)
    : mesh_(std::move(mesh)), counts_(counts), faults_(faults) {
  session_ = client.Watch(mesh_, {}, this);
}

bool SessionWatcher::WaitFor(std::uint64_t last_revision, const MeshHash& hash,
                             absl::Duration limit) {
  return session_->WaitFor(
      [&](const client::MeshReplica& replica) {
        return replica.revision() == last_revision && replica.hash() == hash;
      },
      limit);
}

void SessionWatcher::OnSnapshot(const client::MeshReplica& replica) {
  counts_->resyncs += began_ ? 1 : 0;
  began_ = true;
  revision_ = replica.revision();
}

void SessionWatcher::OnDiff(const client::MeshReplica& replica, const MeshDiff& diff) {
  ++(diff.to_revision > diff.from_revision + 1 ? counts_->coalesced : counts_->revisions);
  revision_ = replica.revision();
}

void SessionWatcher::OnTrouble(const absl::Status& status) {
  // A gap, or another mesh: found by a replica. All else is the connection.
  if (absl::IsFailedPrecondition(status)) {
    ++counts_->lost;
  } else if (absl::IsDataLoss(status)) {
    ++counts_->damaged;
  } else {
    ++counts_->broken;
  }
  faults_->Add(absl::StrCat("a session of ", mesh_, ": ", status.ToString()));
}

void SessionWatcher::OnEnd(const absl::Status& status) {
  if (!absl::IsCancelled(status)) faults_->Add("a session ended: " + status.ToString());
}

}  // namespace dynmesh::soak
