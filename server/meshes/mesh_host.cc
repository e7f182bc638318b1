#include "server/meshes/mesh_host.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/codec/status_codec.h"
#include "server/base/log.h"
#include "server/base/mesh_name.h"
#include "server/meshes/batch_interrupt.h"
#include "server/revisions/revision_error.h"

namespace dynmesh::server {
namespace {

constexpr absl::Duration kRetryAfter = absl::Milliseconds(100);

std::shared_ptr<MeshDiff> EmptyDiff(int dimension, std::uint64_t revision, const MeshHash& hash) {
  auto diff = std::make_shared<MeshDiff>();
  diff->dimension = dimension;
  diff->from_revision = diff->to_revision = revision;
  diff->hash = hash;
  return diff;
}

absl::Status QueueFull(std::size_t waiting) {
  codec::ServiceError error;
  error.reason = codec::reason::kQueueFull;
  error.retry_after = kRetryAfter;
  return codec::MakeServiceError(
      absl::StatusCode::kResourceExhausted,
      absl::StrCat(waiting, " requests wait for this mesh already: try again later"), error);
}

absl::Status ShareFull(absl::string_view client, std::uint64_t share, std::size_t limit) {
  codec::ServiceError error;
  error.reason = codec::reason::kQueueFull;
  error.metadata["client"] = std::string(client);
  error.retry_after = kRetryAfter;
  return codec::MakeServiceError(
      absl::StatusCode::kResourceExhausted,
      absl::StrCat("this client has its share of the requests that may wait for this mesh, ", share,
                   " of ", limit, ": wait for the answers to those it has sent"),
      error);
}

absl::Status CancelledInTime() {
  return absl::CancelledError("the call was cancelled before its turn: nothing changed");
}

absl::Status RevisionMismatch(std::uint64_t expected, std::uint64_t present) {
  codec::ServiceError error;
  error.reason = codec::reason::kRevisionMismatch;
  error.metadata["revision"] = absl::StrCat(present);
  return codec::MakeServiceError(
      absl::StatusCode::kAborted,
      absl::StrCat("the mesh is at revision ", present, ", not at the expected ", expected,
                   ": look at what changed and decide again"),
      error);
}

absl::Status IdReused(absl::string_view request_id, std::uint64_t revision) {
  codec::ServiceError error;
  error.reason = codec::reason::kRequestIdReused;
  error.metadata["revision"] = absl::StrCat(revision);
  error.field = "request_id";
  return codec::MakeServiceError(
      absl::StatusCode::kAlreadyExists,
      absl::StrCat("request_id '", request_id, "' was used for other edits, which made revision ",
                   revision, ": use a new one"),
      error);
}

absl::Status OtherHash(absl::string_view id, const MeshDiff& diff, const MeshHash& expected) {
  return MeshError(absl::StatusCode::kDataLoss, codec::reason::kJournalFailed, id,
                   absl::StrCat("was not changed: its revision ", diff.to_revision,
                                " would have the hash ", diff.hash.ToHex(), ", not ",
                                expected.ToHex(), " as the revision that it repeats"));
}

}  // namespace

std::shared_ptr<MeshHost> MeshHost::Create(std::string id, std::unique_ptr<DynamicMesh> mesh,
                                           absl::Time now, WorkerPool* writers, WorkerPool* readers,
                                           const Options& options, Past past) {
  std::shared_ptr<MeshHost> host(new MeshHost(std::move(id), std::move(mesh), now, writers, readers,
                                              options, std::move(past)));
  if (host->log_ != nullptr) {
    host->queue_->OnRest([weak = std::weak_ptr(host)] {
      const auto held = weak.lock();
      if (held == nullptr) return;
      held->strand_.AssertHeld();
      held->AppendAtRest();
    });
  }
  return host;
}

MeshHost::MeshHost(std::string id, std::unique_ptr<DynamicMesh> mesh, absl::Time now,
                   WorkerPool* writers, WorkerPool* readers, const Options& options, Past past)
    : id_(std::move(id)),
      mesh_options_(mesh->options()),
      create_time_(now),
      max_waiting_(options.max_waiting),
      waiting_(options.max_waiting - options.max_waiting / 2),
      metrics_(options.metrics),
      max_features_(options.max_features),
      max_operations_(options.max_operations),
      memory_(options.memory),
      writers_(writers),
      readers_(readers),
      long_batch_(options.long_batch),
      queue_(
          SerialQueue::Create(writers, past.log == nullptr ? SerialQueue::Turn() : options.turn)),
      store_(past.store != nullptr
                 ? std::move(past.store)
                 : std::make_shared<RevisionStore>(std::make_shared<const Mesh>(mesh->Snapshot()),
                                                   options.history)),
      hub_(WatchHub::Create(store_, readers, options.watch)),
      history_(past.log == nullptr
                   ? std::nullopt
                   : std::make_optional(past.log->History(past.empty.value_or(mesh->hash())))),
      read_only_(std::move(past.read_only)),
      follows_(past.follows.has_value()),
      mesh_(std::move(mesh)),
      log_(std::move(past.log)),
      requests_(past.requests.has_value() ? *std::move(past.requests)
                                          : RequestMemory(options.remembered_requests)),
      pipeline_(options.held),
      snapshots_(options.snapshots),
      seen_snapshot_(past.follows.value_or(0)),
      stats_(mesh_->Stats()) {}

MeshHost::~MeshHost() { hub_->Close(absl::UnavailableError("the mesh was closed")); }

absl::Status MeshHost::Apply(EditJob job) {
  const auto self = shared_from_this();  // the job may finish and release the last other reference
  auto shared = std::make_shared<EditJob>(std::move(job));
  const auto cancelled = shared->cancelled;
  absl::StatusOr<Share> place = TakeWaiting(shared->client);
  if (!place.ok()) return place.status();
  if (*place) shared->waiting = std::make_shared<Share>(*std::move(place));
  if (!queue_->TryPost(TaskOf(shared), max_waiting_, OwnerOf(shared))) {
    return QueueFull(max_waiting_);
  }
  WithdrawIfCancelled(cancelled);
  return absl::OkStatus();
}

void MeshHost::ApplyUnbounded(EditJob job) {
  const auto self = shared_from_this();
  auto shared = std::make_shared<EditJob>(std::move(job));
  const auto cancelled = shared->cancelled;
  queue_->Post(TaskOf(shared), OwnerOf(shared));
  WithdrawIfCancelled(cancelled);
}

absl::StatusOr<Share> MeshHost::TakeWaiting(absl::string_view client) {
  if (client.empty()) return Share();
  Share place = waiting_.Take(client);
  if (!place) return ShareFull(client, waiting_.limit(), max_waiting_);
  return place;
}

// The flag may have turned true before the job was queued.
void MeshHost::WithdrawIfCancelled(const std::shared_ptr<const std::atomic<bool>>& cancelled) {
  if (cancelled != nullptr && cancelled->load()) Withdraw(cancelled);
}

WorkerPool::Task MeshHost::TaskOf(const std::shared_ptr<EditJob>& job) {
  return [self = shared_from_this(), job] {
    self->strand_.AssertHeld();
    self->Run(job);
  };
}

TaskOwner MeshHost::OwnerOf(std::shared_ptr<EditJob> job) {
  if (job->cancelled == nullptr) return {};
  const void* const key = job->cancelled.get();
  return {key, [self = shared_from_this(), job = std::move(job)] {
            absl::StatusOr<EditOutcome> outcome = CancelledInTime();
            EditBatch().swap(job->edits);
            self->Count(*job, outcome);
            job->done(std::move(outcome));
          }};
}

absl::Status MeshHost::Locate(std::vector<double> points,
                              std::shared_ptr<const std::atomic<bool>> cancelled,
                              std::function<void(absl::StatusOr<LocateAnswer>)> done,
                              absl::string_view client) {
  struct Waiting {
    std::vector<double> points;
    Share place;
  };
  absl::StatusOr<Share> place = TakeWaiting(client);
  if (!place.ok()) return place.status();
  auto shared = std::make_shared<Waiting>(Waiting{std::move(points), *std::move(place)});
  const auto task = [self = shared_from_this(), shared, done] {
    self->strand_.AssertHeld();
    if (!self->IsWritten()) return;
    shared->place.Release();
    if (absl::Status status = self->closed(); !status.ok()) return done(status);
    done(LocateAnswer{self->mesh_->revision(), self->mesh_->Locate(shared->points),
                      self->mesh_->LeafSides(shared->points)});
  };
  const TaskOwner owner{cancelled.get(), [done] { done(CancelledInTime()); }};
  return queue_->TryPost(task, max_waiting_, owner) ? absl::OkStatus() : QueueFull(max_waiting_);
}

absl::Status MeshHost::Features(std::optional<std::uint64_t> revision,
                                std::shared_ptr<const std::atomic<bool>> cancelled,
                                std::function<void(absl::StatusOr<FeaturesAt>)> done) {
  if (history_.has_value()) {
    readers_->Post([self = shared_from_this(), revision, cancelled, done = std::move(done)] {
      const Head head = self->head();
      done(self->history_->At(revision.value_or(head.revision), head, cancelled.get()));
    });
    return absl::OkStatus();
  }
  const auto task = [self = shared_from_this(), revision, done] {
    self->strand_.AssertHeld();
    done(self->PresentFeatures(revision));  // there is no log, so nothing is held
  };
  const TaskOwner owner{cancelled.get(), [done] { done(CancelledInTime()); }};
  return queue_->TryPost(task, max_waiting_, owner) ? absl::OkStatus() : QueueFull(max_waiting_);
}

absl::StatusOr<FeaturesAt> MeshHost::PresentFeatures(std::optional<std::uint64_t> revision) const {
  if (absl::Status status = closed(); !status.ok()) return status;
  const Head present{mesh_->revision(), mesh_->hash()};
  if (revision.value_or(present.revision) > present.revision) {
    return FutureRevision(*revision, present, std::nullopt, "ask for one that does");
  }
  if (revision.value_or(present.revision) < present.revision) return NoHistoryError(id_);
  return FeaturesAt{present.revision, present.hash, mesh_->Features()};
}

void MeshHost::Close(const absl::Status& status) {
  {
    const MutexLock lock(mutex_);
    closed_ = status;
  }
  ended_ = true;
  if (log_ != nullptr) log_->EndSnapshots();
  waiters_.Close();
  hub_->Close(status);
}

absl::Status MeshHost::closed() const {
  const MutexLock lock(mutex_);
  return closed_;
}

MeshStats MeshHost::stats() const {
  const MutexLock lock(mutex_);
  return stats_;
}

void MeshHost::Run(const std::shared_ptr<EditJob>& job) {
  if (!IsItsTurn(*job)) return;
  job->waiting.reset();
  const std::uint64_t before = mesh_->revision();
  HeldEdit edit(job);
  activity_.BeginApply(*job);
  edit.outcome = Answer(edit);
  activity_.EndApply();
  if (!edit.outcome.ok() && job->stop != nullptr) job->stop->store(true);
  if (edit.unwritten || !pipeline_.empty()) return Hold(std::move(edit));
  // Answer the writer's caller first: the watchers' threads would compete with it.
  Finish(std::move(edit));
  if (mesh_->revision() != before) {
    hub_->Notify();
    RebaseIfDue();
    SnapshotIfDue();
  }
}

void MeshHost::Finish(HeldEdit edit) {
  EditJob& job = *edit.job;
  Count(job, edit.outcome);
  if (LogEnabled(LogLevel::kDebug)) {
    Log(LogLevel::kDebug, "edit",
        {{"mesh", id_},
         {"call", job.call_id},
         {"request_id", job.request_id},
         {"edits", job.edits.size()},
         {"revision", edit.outcome.ok() ? edit.outcome->diff->to_revision : head().revision},
         {"status", absl::StatusCodeToString(edit.outcome.status().code())},
         {"message", edit.outcome.status().message()}});
  }
  job.done(std::move(edit.outcome));
}

void MeshHost::SetProgress(const EditJob& job, const BatchProgress& progress) {
  activity_.SetProgress(progress);
  if (job.progress != nullptr) job.progress(progress);
}

void MeshHost::Count(const EditJob& job, const absl::StatusOr<EditOutcome>& outcome) {
  if (metrics_ == nullptr) return;
  if (!outcome.ok()) return metrics_->CountAnswer(outcome.status(), EditMetrics::Kind::kApplied);
  const auto kind = outcome->replayed   ? EditMetrics::Kind::kReplayed
                    : job.validate_only ? EditMetrics::Kind::kValidated
                                        : EditMetrics::Kind::kApplied;
  metrics_->CountAnswer(absl::OkStatus(), kind);
  if (kind == EditMetrics::Kind::kApplied) metrics_->ObserveWork(outcome->diff->work, job.source);
}

absl::StatusOr<EditOutcome> MeshHost::Answer(HeldEdit& edit) {
  EditJob& job = *edit.job;
  if (absl::Status status = closed(); !status.ok()) return status;
  if (follows_) return NotOwnerError(id_);
  if (job.stop != nullptr && job.stop->load()) {
    return absl::CancelledError("a batch before it was refused");
  }
  if (!job.refused.ok()) return job.refused;
  if (job.cancelled != nullptr && job.cancelled->load(std::memory_order_relaxed)) {
    return CancelledInTime();
  }
  edit.judged = true;
  // Look for a retry before any check of state that may have changed since the first attempt.
  Fingerprint content;
  if (!job.request_id.empty() && !job.validate_only) {
    content = job.content.has_value() ? *job.content : FingerprintOf(job.edits);
    if (const RequestMemory::Entry* entry = requests_.Find(job.request_id)) {
      if (entry->content != content) return IdReused(job.request_id, entry->to_revision);
      return Replay(*entry);
    }
    if (const HeldEdit* first = pipeline_.Find(job.request_id)) {
      if (first->answer.content != content) {
        return IdReused(job.request_id, first->answer.to_revision);
      }
      EditOutcome again = *first->outcome;
      again.replayed = true;
      return again;
    }
  }
  if (!read_only_.ok()) return read_only_;
  if (job.expected_revision.has_value() && *job.expected_revision != mesh_->revision()) {
    return RevisionMismatch(*job.expected_revision, mesh_->revision());
  }
  if (job.make != nullptr) {
    absl::StatusOr<EditBatch> made = job.make(*mesh_);
    if (!made.ok()) return made.status();
    job.edits = *std::move(made);
  }
  return job.validate_only ? CheckOnly(job) : Change(edit, content);
}

absl::StatusOr<EditOutcome> MeshHost::Replay(const RequestMemory::Entry& entry) const {
  EditOutcome outcome;
  outcome.replayed = true;
  if (entry.from_revision != entry.to_revision) {
    outcome.diff = store_->DiffFrom(entry.from_revision);
  }
  if (outcome.diff == nullptr) {
    auto diff = EmptyDiff(mesh_options_.dimension, entry.from_revision, entry.hash);
    diff->to_revision = entry.to_revision;
    diff->work = entry.work;
    outcome.columns_omitted = entry.from_revision != entry.to_revision;
    outcome.diff = std::move(diff);
  }
  return outcome;
}

absl::StatusOr<EditOutcome> MeshHost::CheckOnly(const EditJob& job) const {
  if (absl::Status status = mesh_->Validate(job.edits); !status.ok()) return status;
  return EditOutcome{EmptyDiff(mesh_options_.dimension, mesh_->revision(), mesh_->hash())};
}

// Batches that only remove are always accepted: they make room.
absl::Status MeshHost::CheckRoom(std::size_t adds, std::size_t removes) const {
  if (adds > removes && mesh_->Stats().features + (adds - removes) > max_features_) {
    codec::ServiceError error;
    error.reason = codec::reason::kFeatureLimit;
    return codec::MakeServiceError(absl::StatusCode::kResourceExhausted,
                                   absl::StrCat("the mesh would have more than the ", max_features_,
                                                " features that this server allows one mesh"),
                                   error);
  }
  return memory_ == nullptr ? absl::OkStatus() : memory_->CheckRoom();
}

absl::StatusOr<EditOutcome> MeshHost::Change(HeldEdit& edit, const Fingerprint& content) {
  EditJob& job = *edit.job;
  ApplyOptions apply_options;
  const auto count = [&](Edit::Action action) {
    return static_cast<std::size_t>(
        std::count_if(job.edits.begin(), job.edits.end(),
                      [action](const Edit& e) { return e.action == action; }));
  };
  const std::size_t removes = count(Edit::Action::kRemove);
  const bool grows = removes < job.edits.size();
  if (grows) {
    if (absl::Status s = CheckRoom(count(Edit::Action::kAdd), removes); !s.ok()) return s;
  }
  apply_options.interrupted =
      BatchInterrupt(job.cancelled.get(), grows && memory_ != nullptr ? memory_->full() : nullptr);
  apply_options.max_operations = max_operations_;
  apply_options.progress = [&](const ApplyProgress& progress) {
    strand_.AssertHeld();
    SetProgress(job, progress);
    Relieve();
  };
  const bool held = CanBeHeld(job);
  apply_options.revocable = held;
  apply_options.commit = [&](const MeshDiff& d) {
    strand_.AssertHeld();
    edit.answer = {content, d.from_revision, d.to_revision, d.hash, d.work};
    if (job.expected_hash.value_or(d.hash) != d.hash) return OtherHash(id_, d, *job.expected_hash);
    if (log_ == nullptr || held) return absl::OkStatus();
    SetProgress(job, BatchProgress::Journal());
    log_->writer().AssertHeld();  // nothing is in flight: it was this batch's turn
    const MeshLog::Batch alone{&job.edits, job.request_id, edit.answer};
    return WriteDown({&alone, 1}, job.source);
  };
  const MeshHash before = mesh_->hash();
  absl::StatusOr<MeshDiff> applied = mesh_->Apply(job.edits, apply_options);
  if (const MeshHash& due = applied.ok() ? applied->hash : before; mesh_->hash() != due) {
    return Lose(absl::StrCat("it has the hash ", mesh_->hash().ToHex(), ", not ", due.ToHex(),
                             applied.ok() ? ", after a batch" : ", after a batch was undone"));
  }
  if (!applied.ok()) {
    const bool stopped = grows && memory_ != nullptr && absl::IsCancelled(applied.status()) &&
                         (job.cancelled == nullptr || !job.cancelled->load());
    return stopped ? memory_->RefuseGrowth() : applied.status();
  }
  auto diff = std::make_shared<const MeshDiff>(*std::move(applied));
  edit.stats = mesh_->Stats();
  if (held) {
    edit.unwritten = diff->from_revision != diff->to_revision || !job.request_id.empty();
  } else if (absl::Status s = Publish(edit, diff); !s.ok()) {
    return s;
  }
  return EditOutcome{std::move(diff)};
}

absl::Status MeshHost::WriteDown(std::span<const MeshLog::Batch> batches, EditSource source) {
  if (disowned_) return NotOwnerError(id_);
  const auto start = MetricsClock::now();
  absl::Status written = log_->Append(batches);
  if (metrics_ != nullptr) metrics_->of(source).journal.Observe(SecondsSince(start));
  if (!log_->owns()) StepDown(written);
  return written;
}

// The journal is no longer this host's: another server may write to it.
void MeshHost::StepDown(const absl::Status& why) {
  if (disowned_.exchange(true)) return;
  Log(LogLevel::kWarning, "mesh_disowned", {{"mesh", id_}, {"error", why.message()}});
  Close(NotOwnerError(id_));
}

absl::Status MeshHost::Publish(const HeldEdit& edit, const std::shared_ptr<const MeshDiff>& diff) {
  if (diff->from_revision != diff->to_revision) {
    if (absl::Status status = store_->Append(diff); !status.ok()) return Lose(status.message());
    const MutexLock lock(mutex_);
    stats_ = edit.stats;
  }
  if (!edit.job->request_id.empty()) requests_.Remember(edit.job->request_id, edit.answer);
  return absl::OkStatus();
}

// The mesh broke an invariant. Readers keep the last good state.
absl::Status MeshHost::Lose(absl::string_view why) {
  Log(LogLevel::kError, "lost_revision", {{"mesh", id_}, {"error", why}});
  const absl::Status lost =
      absl::InternalError(absl::StrCat("mesh ", id_, " can no longer be followed: ", why));
  Close(lost);
  return lost;
}

void MeshHost::RebaseIfDue() {
  if (!store_->wants_rebase() || rebasing_.exchange(true)) return;
  readers_->Post([self = shared_from_this()] {
    const auto latest = self->store_->Latest();
    self->rebasing_.store(false);
    if (!latest.ok()) {
      Log(LogLevel::kError, "snapshot_failed",
          {{"mesh", self->id_}, {"error", latest.status().message()}});
    }
  });
}

}  // namespace dynmesh::server
