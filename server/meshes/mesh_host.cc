#include "server/meshes/mesh_host.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/codec/status_codec.h"
#include "server/base/mesh_name.h"
#include "server/meshes/batch_interrupt.h"
#include "server/revisions/revision_error.h"

namespace dynmesh::server {
namespace {

std::shared_ptr<MeshDiff> EmptyDiff(int dimension, std::uint64_t revision, const MeshHash& hash) {
  auto diff = std::make_shared<MeshDiff>();
  diff->dimension = dimension;
  diff->from_revision = diff->to_revision = revision;
  diff->hash = hash;
  return diff;
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
  return std::shared_ptr<MeshHost>(new MeshHost(std::move(id), std::move(mesh), now, writers,
                                                readers, options, std::move(past)));
}

MeshHost::MeshHost(std::string id, std::unique_ptr<DynamicMesh> mesh, absl::Time now,
                   WorkerPool* writers, WorkerPool* readers, const Options& options, Past past)
    : id_(std::move(id)),
      mesh_options_(mesh->options()),
      create_time_(now),
      max_features_(options.max_features),
      max_operations_(options.max_operations),
      memory_(options.memory),
      read_only_(std::move(past.read_only)),
      has_log_(past.log != nullptr),
      follows_(past.follows.has_value()),
      strand_(std::make_shared<MeshStrand>(writers, has_log_ ? options.turn : SerialQueue::Turn(),
                                           options.max_waiting)),
      readers_(MeshReaders::Create(
          id_,
          past.store != nullptr
              ? std::move(past.store)
              : std::make_shared<RevisionStore>(std::make_shared<const Mesh>(mesh->Snapshot()),
                                                options.history),
          has_log_ ? std::make_optional(past.log->History(past.empty.value_or(mesh->hash())))
                   : std::nullopt,
          mesh->Stats(), readers, options.watch)),
      mesh_(mesh.get()),
      writer_(MeshWriter::Create(
          id_, std::move(mesh), strand_, readers_, std::move(past.log),
          past.requests.has_value() ? *std::move(past.requests)
                                    : RequestMemory(options.remembered_requests),
          writers,
          {options.held, options.long_batch, options.snapshots, options.metrics, options.memory})),
      seen_snapshot_(past.follows.value_or(0)) {}

// --- calls: their turn

absl::Status MeshHost::Apply(EditJob job) {
  const auto self = shared_from_this();  // the job may finish and release the last other reference
  auto shared = std::make_shared<EditJob>(std::move(job));
  const auto cancelled = shared->cancelled;
  absl::StatusOr<Share> share = strand_->Take(shared->client);
  if (!share.ok()) return share.status();
  if (*share) shared->waiting = std::make_shared<Share>(*std::move(share));
  if (absl::Status s = strand_->TryPost(TaskOf(shared), OwnerOf(shared)); !s.ok()) return s;
  strand_->WithdrawIf(cancelled);  // it may have turned true before the job was queued
  return absl::OkStatus();
}

void MeshHost::ApplyUnbounded(EditJob job) {
  const auto self = shared_from_this();
  auto shared = std::make_shared<EditJob>(std::move(job));
  const auto cancelled = shared->cancelled;
  strand_->Post(TaskOf(shared), OwnerOf(shared));
  strand_->WithdrawIf(cancelled);
}

WorkerPool::Task MeshHost::TaskOf(const std::shared_ptr<EditJob>& job) {
  return [self = shared_from_this(), job] {
    self->writer_->strand().AssertHeld();
    self->Run(job);
  };
}

TaskOwner MeshHost::OwnerOf(std::shared_ptr<EditJob> job) {
  if (job->cancelled == nullptr) return {};
  const void* const key = job->cancelled.get();
  return {key, [self = shared_from_this(), job = std::move(job)] {
            absl::StatusOr<EditOutcome> outcome = CancelledInTime();
            EditBatch().swap(job->edits);
            self->writer_->Count(*job, outcome);
            job->done(std::move(outcome));
          }};
}

absl::Status MeshHost::Locate(std::vector<double> points,
                              std::shared_ptr<const std::atomic<bool>> cancelled,
                              std::function<void(absl::StatusOr<LocateAnswer>)> done,
                              absl::string_view client) {
  struct Waiting {
    std::vector<double> points;
    Share share;
  };
  absl::StatusOr<Share> share = strand_->Take(client);
  if (!share.ok()) return share.status();
  auto shared = std::make_shared<Waiting>(Waiting{std::move(points), *std::move(share)});
  const auto task = [self = shared_from_this(), shared, done] {
    self->writer_->strand().AssertHeld();
    if (!self->writer_->IsWritten()) return;
    shared->share.Release();
    if (absl::Status status = self->readers_->closed(); !status.ok()) return done(status);
    done(LocateAnswer{self->mesh_->revision(), self->mesh_->Locate(shared->points),
                      self->mesh_->LeafSides(shared->points)});
  };
  const TaskOwner owner{cancelled.get(), [done] { done(CancelledInTime()); }};
  return strand_->TryPost(task, owner);
}

absl::Status MeshHost::Features(std::optional<std::uint64_t> revision,
                                std::shared_ptr<const std::atomic<bool>> cancelled,
                                std::function<void(absl::StatusOr<FeaturesAt>)> done) {
  if (history() != nullptr) {
    readers_->FeaturesAtRevision(revision, std::move(cancelled), std::move(done));
    return absl::OkStatus();
  }
  const auto task = [self = shared_from_this(), revision, done] {
    self->writer_->strand().AssertHeld();
    done(self->PresentFeatures(revision));  // there is no log, so nothing is held
  };
  const TaskOwner owner{cancelled.get(), [done] { done(CancelledInTime()); }};
  return strand_->TryPost(task, owner);
}

absl::StatusOr<FeaturesAt> MeshHost::PresentFeatures(std::optional<std::uint64_t> revision) const {
  if (absl::Status status = readers_->closed(); !status.ok()) return status;
  const Head present{mesh_->revision(), mesh_->hash()};
  if (revision.value_or(present.revision) > present.revision) {
    return FutureRevision(*revision, present, std::nullopt, "ask for one that does");
  }
  if (revision.value_or(present.revision) < present.revision) return NoHistoryError(id_);
  return FeaturesAt{present.revision, present.hash, mesh_->Features()};
}

// --- a batch in its turn

void MeshHost::Run(const std::shared_ptr<EditJob>& job) {
  if (!writer_->IsItsTurn(*job)) return;
  job->waiting.reset();
  const std::uint64_t before = mesh_->revision();
  HeldEdit edit(job);
  writer_->activity().BeginApply(*job);
  edit.outcome = Judge(edit);
  writer_->activity().EndApply();
  if (!edit.outcome.ok() && job->stop != nullptr) job->stop->store(true);
  writer_->Settle(std::move(edit), mesh_->revision() != before);
}

void MeshHost::SetProgress(const EditJob& job, const BatchProgress& progress) {
  writer_->activity().SetProgress(progress);
  if (job.progress != nullptr) job.progress(progress);
}

// What the batch is answered. Applies it if nothing is against that.
absl::StatusOr<EditOutcome> MeshHost::Judge(HeldEdit& edit) {
  EditJob& job = *edit.job;
  if (absl::Status status = readers_->closed(); !status.ok()) return status;
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
    if (const RequestMemory::Entry* entry = writer_->FindAnswered(job.request_id)) {
      if (entry->content != content) return IdReused(job.request_id, entry->to_revision);
      return Replay(*entry);
    }
    if (const HeldEdit* first = writer_->FindHeld(job.request_id)) {
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
    outcome.diff = store()->DiffFrom(entry.from_revision);
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
    writer_->strand().AssertHeld();
    SetProgress(job, progress);
    writer_->PublishMeanwhile();
  };
  const bool held = writer_->CanBeHeld(job);
  apply_options.revocable = held;
  apply_options.commit = [&](const MeshDiff& d) {
    writer_->strand().AssertHeld();
    edit.answer = {content, d.from_revision, d.to_revision, d.hash, d.work};
    if (job.expected_hash.value_or(d.hash) != d.hash) return OtherHash(id_, d, *job.expected_hash);
    if (!has_log_ || held) return absl::OkStatus();
    SetProgress(job, BatchProgress::Journal());
    return writer_->WriteAlone(job, edit.answer);
  };
  const MeshHash before = mesh_->hash();
  absl::StatusOr<MeshDiff> applied = mesh_->Apply(job.edits, apply_options);
  if (const MeshHash& due = applied.ok() ? applied->hash : before; mesh_->hash() != due) {
    return writer_->CloseBroken(
        absl::StrCat("it has the hash ", mesh_->hash().ToHex(), ", not ", due.ToHex(),
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
  } else if (absl::Status s = writer_->Publish(edit, diff); !s.ok()) {
    return s;
  }
  return EditOutcome{std::move(diff)};
}

}  // namespace dynmesh::server
