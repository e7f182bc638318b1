#include "server/meshes/mesh_registry.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "proto/codec/status_codec.h"
#include "server/base/log.h"
#include "server/base/printable.h"
#include "server/cluster/placement.h"
#include "server/meshes/batch_interrupt.h"
#include "server/meshes/recovery.h"
#include "server/meshes/recovery_progress.h"

namespace dynmesh::server {
namespace {

// Attempts to read a mesh at the start: pauses double from the first one on.
constexpr absl::Duration kFirstPause = absl::Milliseconds(250);
constexpr absl::Duration kRecoverFor = absl::Seconds(30);

absl::Status MeshExistsError(absl::string_view id) {
  return MeshError(absl::StatusCode::kAlreadyExists, codec::reason::kMeshExists, id,
                   "exists already");
}

// One part per task of the pool, which is of normal priority: appends wait for each. Does not use
// the registry, which is destroyed before its pools.
void SweepOn(WorkerPool* pool, Journal* journal, Journal::Key mesh,
             const std::shared_ptr<std::atomic<bool>>& ended) {
  pool->Post([=] {
    if (!*ended && journal->Sweep(mesh)) SweepOn(pool, journal, mesh, ended);
  });
}

std::shared_ptr<Snapshots> SnapshotsOf(Journal* journal, ServerMetrics* metrics) {
  if (journal == nullptr) return nullptr;
  if (metrics == nullptr) return std::make_shared<Snapshots>(journal);
  return std::make_shared<Snapshots>(journal, [metrics](const Snapshots::Made& made) {
    metrics->snapshots.Observe(made.take, made.encode, made.write);
  });
}

}  // namespace

absl::Status MeshRegistry::DamageOf(absl::string_view id, const absl::Status& status) {
  return MeshError(absl::StatusCode::kDataLoss, codec::reason::kMeshDamaged, id,
                   absl::StrCat("is damaged: ", Printable(status.message()),
                                ". Restore the server's data folder, or delete the mesh"));
}

MeshRegistry::MeshRegistry(const ServerConfig& config, MeshFactory factory, WorkerPool* writers,
                           WorkerPool* readers, Journal* journal, ServerMetrics* metrics,
                           const MemoryGuard* memory)
    : config_(config),
      factory_(std::move(factory)),
      writers_(writers),
      readers_(readers),
      journal_(journal),
      metrics_(metrics),
      memory_(memory),
      snapshots_(SnapshotsOf(journal, metrics)) {}

MeshHost::Options MeshRegistry::HostOptions() const {
  MeshHost::Options options;
  options.history = {config_.history_revisions, config_.history_bytes};
  options.watch = {config_.watch_queue, config_.progress_interval};
  options.max_waiting = config_.max_waiting_edits;
  options.remembered_requests = config_.remembered_requests;
  options.compact = {config_.compact_bytes, config_.compact_operations};
  options.snapshots = snapshots_;
  if (metrics_ != nullptr) options.metrics = &metrics_->edits;
  options.max_features = config_.max_features;
  options.max_operations = config_.max_batch_operations;
  options.memory = memory_;
  return options;
}

std::uint64_t MeshRegistry::MaxVertices(int dimension) const {
  if (config_.max_vertices != 0) return config_.max_vertices;
  return memory_ != nullptr ? memory_->MostVertices(dimension) : Limits().max_vertices;
}

MeshRegistry::~MeshRegistry() {
  ends_ = true;
  past_pool_.Stop();
  if (snapshots_ != nullptr) snapshots_->Stop();
  if (opener_ != nullptr) {
    followers_->Stop();
    opener_.reset();                  // it loads into this
    shared_->GiveUp().IgnoreError();  // what was claimed after a drain; else it runs out
  }
  EndSweeps();
  CloseAll(absl::UnavailableError("the server has ended"));
}

absl::StatusOr<MeshRegistry::HostPtr> MeshRegistry::FindCreated(
    const std::string& id, const MeshOptions& options, const std::string& request_id) const {
  if (request_id.empty()) return HostPtr();
  const auto made = id.empty() ? made_.find(request_id) : made_.end();
  const auto it = hosts_.find(made == made_.end() ? id : made->second);
  if (it == hosts_.end() || it->second.host == nullptr || it->second.request_id != request_id) {
    return HostPtr();
  }
  const MeshOptions& made_with = it->second.host->mesh_options();
  MeshOptions asked = options;
  // The server that made it may have had another limit.
  if (shared_ != nullptr && asked.limits.max_vertices == MaxVertices(asked.dimension)) {
    asked.limits.max_vertices = made_with.limits.max_vertices;
  }
  if (asked != made_with) {
    return MeshError(absl::StatusCode::kAlreadyExists, codec::reason::kRequestIdReused, it->first,
                     "was made with this request_id and other content: use a new one");
  }
  return it->second.host;
}

absl::Status MeshRegistry::CheckRoom(const std::string& id) const {
  if (const auto it = hosts_.find(id); it != hosts_.end()) {
    if (it->second.host == nullptr) return it->second.damage;
    return MeshExistsError(id);
  }
  if (hosts_.size() >= config_.max_meshes) {
    codec::ServiceError error;
    error.reason = codec::reason::kMeshLimit;
    return codec::MakeServiceError(
        absl::StatusCode::kResourceExhausted,
        absl::StrCat("the server holds its limit of ", config_.max_meshes, " meshes: delete one"),
        error);
  }
  return absl::OkStatus();
}

std::string MeshRegistry::FreshId(const std::string& request_id) {
  if (shared_ != nullptr && !request_id.empty()) {
    // A retry at another server is to find the mesh.
    std::string id = absl::StrFormat("m-%012x", PlacementWeight("", request_id) & 0xffffffffffffu);
    if (!hosts_.contains(id)) return id;
  }
  while (true) {
    std::string id = absl::StrFormat("m-%012x", random_() & 0xffffffffffffu);
    if (!hosts_.contains(id)) return id;
  }
}

absl::StatusOr<MeshRegistry::HostPtr> MeshRegistry::Create(const std::string& id,
                                                           const MeshOptions& options,
                                                           const std::string& request_id,
                                                           const std::atomic<bool>* cancelled,
                                                           const Origin& origin) {
  if (!id.empty() && !IsMeshId(id)) {
    return BadName("mesh_id", id, "[a-z][a-z0-9-]{0,62}");
  }
  // Checked before the mesh is made, to save the work, and again after.
  {
    const MutexLock lock(mutex_);
    auto created = FindCreated(id, options, request_id);
    if (!created.ok() || *created != nullptr) return created;
    if (absl::Status status = CheckRoom(id); !status.ok()) return status;
  }
  absl::StatusOr<std::unique_ptr<DynamicMesh>> mesh = Make(options, cancelled);
  if (!mesh.ok()) return mesh.status();

  const MutexLock changing(changing_mutex_);
  std::string final_id = id;
  {
    const MutexLock lock(mutex_);
    auto created = FindCreated(id, options, request_id);
    if (!created.ok() || *created != nullptr) return created;
    if (absl::Status status = CheckRoom(id); !status.ok()) return status;
    if (id.empty()) final_id = FreshId(request_id);
  }
  const absl::Time now = absl::Now();
  const absl::StatusOr<Journal::Key> key = WriteDown(final_id, {options, now, request_id});
  if (!key.ok()) return key.status();
  const MeshHost::Options host_options = HostOptions();
  MeshHost::Past past;
  if (journal_ != nullptr) {
    past.log = std::make_unique<MeshLog>(journal_, *key, final_id, options.dimension,
                                         MeshLog::Sizes(), host_options.compact);
  }
  HostPtr host = MeshHost::Create(final_id, *std::move(mesh), now, writers_, readers_, host_options,
                                  std::move(past));
  const MutexLock lock(mutex_);
  hosts_.emplace(final_id, Kept{host, {}, *key, request_id});
  if (!request_id.empty()) made_.emplace(request_id, final_id);
  Log(LogLevel::kInfo, "mesh_created",
      {{"mesh", final_id},
       {"meshes", hosts_.size()},
       {"client", origin.client},
       {"call", origin.call}});
  return host;
}

absl::StatusOr<std::unique_ptr<DynamicMesh>> MeshRegistry::Make(
    const MeshOptions& options, const std::atomic<bool>* cancelled) const {
  ApplyOptions apply;
  apply.max_operations = config_.max_batch_operations;
  if (memory_ != nullptr) {
    if (absl::Status status = memory_->CheckRoom(); !status.ok()) return status;
  }
  apply.interrupted = BatchInterrupt(cancelled, memory_ != nullptr ? memory_->full() : nullptr);
  auto mesh = factory_(options, apply);
  const bool is_wanted = cancelled == nullptr || !cancelled->load(std::memory_order_relaxed);
  if (absl::IsCancelled(mesh.status()) && is_wanted && memory_ != nullptr) {
    return memory_->RefuseGrowth();
  }
  return mesh;
}

absl::StatusOr<Journal::Key> MeshRegistry::WriteDown(const std::string& id,
                                                     const codec::JournalMesh& mesh) {
  if (journal_ == nullptr) return Journal::Key{0};
  absl::StatusOr<Journal::Key> key = journal_->Create(id, codec::EncodeJournalMesh(mesh));
  if (key.ok()) return key;
  if (absl::IsAlreadyExists(key.status())) return MeshExistsError(id);  // at another server
  return JournalError(key.status(), id);
}

absl::Status MeshRegistry::Recover() {
  if (journal_ == nullptr) return absl::OkStatus();
  const absl::StatusOr<std::vector<Journal::Mesh>> meshes = journal_->List();
  if (!meshes.ok()) return meshes.status();
  RecoveryProgress progress(*meshes, metrics_ == nullptr ? nullptr : &metrics_->recovery);
  for (const Journal::Mesh& mesh : *meshes) {
    writers_->Post([this, &mesh, &progress] {
      RecoverOne(mesh, progress);
      progress.EndMesh();
    });
  }
  progress.Wait(config_.report_interval);
  return absl::OkStatus();
}

// A journal that does not answer says nothing about the mesh: a database may be starting again. So
// the mesh is read again then, for kRecoverFor.
absl::StatusOr<RecoveredMesh> MeshRegistry::ReadAtStart(const Journal::Mesh& mesh, absl::Time start,
                                                        RecoveryProgress& progress) {
  std::uint64_t reported = 0;
  for (absl::Duration pause = kFirstPause;; pause *= 2) {
    std::uint64_t applied = 0;
    absl::StatusOr<RecoveredMesh> found =
        RecoverMesh(*journal_, mesh, factory_, HostOptions(), [&] {
          if (++applied <= reported) return;  // by a former attempt
          reported = applied;
          progress.Apply();
        });
    if (!absl::IsUnavailable(found.status()) || absl::Now() + pause > start + kRecoverFor) {
      return found;
    }
    Log(LogLevel::kWarning, "not_recovered",
        {{"mesh", mesh.id},
         {"error", found.status().message()},
         {"again_in_ms", absl::ToInt64Milliseconds(pause)}});
    absl::SleepFor(pause);
  }
}

void MeshRegistry::RecoverOne(const Journal::Mesh& mesh, RecoveryProgress& progress) {
  const absl::Time start = absl::Now();
  absl::StatusOr<RecoveredMesh> found = ReadAtStart(mesh, start, progress);
  if (!found.ok()) {
    Log(LogLevel::kError, "mesh_damaged", {{"mesh", mesh.id}, {"error", found.status().message()}});
    progress.Damage();
    const MutexLock lock(mutex_);
    hosts_.emplace(mesh.id, Kept{nullptr, DamageOf(mesh.id, found.status()), mesh.key, {}});
    return;
  }
  if (!mesh.loss.ok()) progress.Damage();
  Put(mesh, *std::move(found), start);
}

MeshRegistry::HostPtr MeshRegistry::Put(const Journal::Mesh& mesh, RecoveredMesh found,
                                        absl::Time start) {
  absl::Status damage;
  if (!mesh.loss.ok()) {
    damage = DamageOf(mesh.id, mesh.loss);
    found.past.read_only = damage;
  }
  const codec::JournalMesh made = found.made;
  HostPtr host = MeshHost::Create(mesh.id, std::move(found.mesh), made.create_time, writers_,
                                  readers_, HostOptions(), std::move(found.past));
  Log(LogLevel::kInfo, "recovered",
      {{"mesh", mesh.id},
       {"revision", host->head().revision},
       {"hash", host->head().hash.ToHex()},
       {"features", host->stats().features},
       {"entries", found.entries},
       {"milliseconds", absl::ToInt64Milliseconds(absl::Now() - start)}});
  const MutexLock lock(mutex_);
  if (!made.request_id.empty()) made_.emplace(made.request_id, mesh.id);
  hosts_.insert_or_assign(mesh.id, Kept{host, damage, mesh.key, made.request_id});
  return host;
}

absl::StatusOr<MeshRegistry::HostPtr> MeshRegistry::Find(absl::string_view name) const {
  const absl::StatusOr<std::string> id = ParseMeshName(name);
  if (!id.ok()) return id.status();
  const MutexLock lock(mutex_);
  const auto it = hosts_.find(*id);
  if (it == hosts_.end()) return MeshNotFoundError(*id);
  if (it->second.host == nullptr) return it->second.damage;
  if (it->second.host->disowned()) return NotOwnerError(*id);
  return it->second.host;
}

absl::Status MeshRegistry::Delete(absl::string_view name, const Origin& origin) {
  const absl::StatusOr<std::string> id = ParseMeshName(name);
  if (!id.ok()) return id.status();
  Kept kept;
  bool is_here = false;
  const MutexLock changing(changing_mutex_);
  {
    const MutexLock lock(mutex_);
    const auto it = hosts_.find(*id);
    is_here = it != hosts_.end();
    if (is_here) kept = it->second;
  }
  if (!is_here || (shared_ != nullptr && kept.host != nullptr && kept.host->disowned())) {
    // It may be another server's.
    const absl::StatusOr<Journal::Key> key = KeyElsewhere(*id);
    if (!key.ok()) return key.status();
    kept.key = *key;
  }
  // From here on the journal refuses the mesh's edits.
  if (journal_ != nullptr) {
    if (absl::Status s = journal_->Delete(kept.key); !s.ok()) return JournalError(s, *id);
  }
  {
    const MutexLock lock(mutex_);
    hosts_.erase(*id);
    std::erase_if(made_, [&](const auto& made) { return made.second == *id; });
  }
  if (kept.host != nullptr) kept.host->Close(MeshDeletedError(*id));
  if (journal_ != nullptr) SweepOn(writers_, journal_, kept.key, sweeps_ended_);
  Log(LogLevel::kInfo, "mesh_deleted",
      {{"mesh", *id}, {"client", origin.client}, {"call", origin.call}});
  return absl::OkStatus();
}

std::vector<MeshRegistry::Listed> MeshRegistry::List(
    absl::string_view after, std::size_t limit,
    const std::function<bool(absl::string_view)>& shown) const {
  const MutexLock lock(mutex_);
  std::vector<Listed> found;
  for (auto it = hosts_.upper_bound(after); it != hosts_.end() && found.size() < limit; ++it) {
    if (shown != nullptr && !shown(it->first)) continue;
    found.push_back({it->first, it->second.host, it->second.damage, "", 0, {}});
  }
  return found;
}

std::vector<MeshRegistry::HostPtr> MeshRegistry::Hosts() const {
  const MutexLock lock(mutex_);
  std::vector<HostPtr> hosts;
  for (const auto& [id, kept] : hosts_) {
    if (kept.host != nullptr) hosts.push_back(kept.host);
  }
  return hosts;
}

std::size_t MeshRegistry::size() const {
  const MutexLock lock(mutex_);
  return hosts_.size();
}

std::size_t MeshRegistry::damaged() const {
  const MutexLock lock(mutex_);
  return static_cast<std::size_t>(std::count_if(
      hosts_.begin(), hosts_.end(), [](const auto& kept) { return !kept.second.damage.ok(); }));
}

std::size_t MeshRegistry::watchers() const {
  std::size_t sum = 0;
  for (const HostPtr& host : Hosts()) sum += host->hub()->size();
  for (const Followers::Followed& followed : Followed()) sum += followed.host->hub()->size();
  return sum;
}

void MeshRegistry::Tick(absl::Time now) {
  for (const HostPtr& host : Hosts()) {
    host->hub()->Tick(now);
    host->ReportLongWork(config_.report_interval);
  }
  for (const Followers::Followed& followed : Followed()) followed.host->hub()->Tick(now);
}

void MeshRegistry::CloseAll(const absl::Status& status) {
  for (const HostPtr& host : Hosts()) host->Close(status);
}

void MeshRegistry::CloseWatches(const absl::Status& status) {
  ends_ = true;  // for watches that begin in the past
  for (const HostPtr& host : Hosts()) host->hub()->Close(status);
  if (followers_ != nullptr) followers_->CloseWatches(status);
}

}  // namespace dynmesh::server
