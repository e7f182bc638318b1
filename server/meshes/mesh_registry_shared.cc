// The part of MeshRegistry for a journal that several servers share.
#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "proto/codec/status_codec.h"
#include "server/base/log.h"
#include "server/cluster/placement.h"
#include "server/meshes/hand_over.h"
#include "server/meshes/mesh_registry.h"
#include "server/meshes/recovery.h"
#include "server/revisions/revision_error.h"

namespace dynmesh::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kPage = 1'000;
// A read waits so long for a revision, or for the mesh to be followed; then its owner is named.
constexpr std::chrono::seconds kFollowerPatience(1);

absl::Status Lost() { return absl::AbortedError("another server has the mesh"); }

}  // namespace

absl::Status MeshRegistry::Join(const std::string& address, std::function<bool()> reads) {
  shared_ = journal_ == nullptr ? nullptr : journal_->shared();
  if (shared_ == nullptr) {
    return absl::FailedPreconditionError("node-address: the journal is of one server");
  }
  address_ = address;
  reads_ = std::move(reads);
  opener_ = std::make_unique<MeshOpener>(
      shared_, address_, [this](const Journal::Mesh& mesh) { return LoadShared(mesh); });
  StartFollowers();
  if (absl::Status s = Renew(); !s.ok()) return s;
  return OpenChosen();
}

void MeshRegistry::StartFollowers() {
  Followers::Options options;
  options.per_mesh = config_.followers;
  options.max_meshes = config_.max_followed_meshes;
  options.idle = absl::ToChronoNanoseconds(config_.follower_idle);
  Followers::Calls calls;
  calls.make = [this](const Journal::Mesh& mesh) { return MakeFollower(mesh); };
  calls.take_over = [this](const std::string& id, std::function<void()> done) {
    opener_->Open(id, {}, [done = std::move(done)](const absl::StatusOr<HostPtr>&) { done(); });
  };
  calls.owned = [this] {
    std::vector<Followers::Owned> owned;
    const MutexLock lock(mutex_);
    for (const auto& [id, kept] : hosts_) {
      if (kept.host == nullptr || kept.host->disowned()) continue;
      owned.push_back({kept.key, id, kept.host->head().revision});
    }
    return owned;
  };
  calls.check_room = [this] {
    return memory_ == nullptr ? absl::OkStatus() : memory_->CheckRoom();
  };
  followers_ = std::make_unique<Followers>(shared_, address_, options, std::move(calls),
                                           metrics_ == nullptr ? nullptr : &metrics_->followers);
}

absl::StatusOr<MeshRegistry::HostPtr> MeshRegistry::MakeFollower(const Journal::Mesh& mesh) const {
  absl::StatusOr<RecoveredMesh> found = ReadMesh(*journal_, mesh, factory_, HostOptions());
  if (!found.ok()) return found.status();
  return MeshHost::Create(mesh.id, std::move(found->mesh), found->made.create_time, writers_,
                          readers_, HostOptions(), std::move(found->past));
}

// The free meshes of this node. They are opened while calls are answered.
absl::Status MeshRegistry::OpenChosen() {
  const absl::StatusOr<std::vector<std::string>> nodes = shared_->LiveNodes();
  if (!nodes.ok()) return nodes.status();
  std::string after;
  while (true) {
    const absl::StatusOr<std::vector<SharedJournal::Located>> all =
        shared_->LocateAll(after, kPage);
    if (!all.ok()) return all.status();
    for (const SharedJournal::Located& located : *all) {
      after = located.mesh.id;
      if (located.left > absl::ZeroDuration()) continue;
      const auto chosen = ChooseNode(*nodes, located.mesh.id);
      if (chosen.has_value() && (*nodes)[*chosen] != address_) continue;
      opener_->Open(located.mesh.id, {}, [](const absl::StatusOr<HostPtr>&) {});
    }
    if (all->size() < kPage) return absl::OkStatus();
  }
}

absl::Status MeshRegistry::Renew() {
  // What was here before the renewal was sent is either among those renewed, or lost.
  std::vector<std::pair<std::string, Kept>> before;
  {
    const MutexLock lock(mutex_);
    before.assign(hosts_.begin(), hosts_.end());
  }
  const absl::StatusOr<std::vector<Journal::Key>> renewed = shared_->Renew(address_);
  if (!renewed.ok()) return renewed.status();
  for (const auto& [id, kept] : before) {
    const bool is_mine = std::binary_search(renewed->begin(), renewed->end(), kept.key);
    const bool is_done = kept.host != nullptr && kept.host->disowned();
    if (!is_mine || is_done) Drop(id, kept.host, Lost());
  }
  return absl::OkStatus();
}

void MeshRegistry::Drop(const std::string& id, const HostPtr& host, const absl::Status& why) {
  if (host != nullptr) host->StepDown(why);
  const MutexLock lock(mutex_);
  const auto it = hosts_.find(id);
  if (it == hosts_.end() || it->second.host != host) return;
  hosts_.erase(it);
  // A large mesh takes long to free.
  writers_->Post([host] {});
}

void MeshRegistry::Open(absl::string_view name, const Asking& asking, MeshOpener::Done done) {
  absl::StatusOr<HostPtr> here = Find(name);
  if (opener_ == nullptr || here.ok()) return done(std::move(here));
  const absl::StatusOr<std::string> id = ParseMeshName(name);
  HostPtr gone;
  bool is_here = !id.ok();  // a malformed name is answered here, too
  if (id.ok()) {
    const MutexLock lock(mutex_);
    if (const auto it = hosts_.find(*id); it != hosts_.end()) {
      if (it->second.host != nullptr && it->second.host->disowned()) {
        gone = it->second.host;
      } else {
        is_here = true;  // damaged, or opened meanwhile
      }
    }
  }
  if (is_here) return done(Find(name));
  if (gone != nullptr) Drop(*id, gone, Lost());
  opener_->Open(*id, asking, std::move(done));
}

void MeshRegistry::OpenToRead(absl::string_view name, const Asking& asking,
                              std::optional<std::uint64_t> min_revision, MeshOpener::Done done) {
  if (!min_revision.has_value()) return Open(name, asking, std::move(done));
  auto check = [revision = *min_revision, done](const absl::StatusOr<HostPtr>& host) {
    if (!host.ok() || (*host)->head().revision >= revision) return done(host);
    done(FutureRevision(revision, (*host)->head(), std::nullopt, "ask for one that does"));
  };
  const absl::StatusOr<std::string> id = ParseMeshName(name);
  const absl::StatusOr<HostPtr> here = Find(name);
  const bool may_follow = followers_ != nullptr && id.ok() && !absl::IsDataLoss(here.status());
  if (here.ok() || !may_follow) return Open(name, asking, std::move(check));
  const Clock::time_point end = std::min(asking.deadline, Clock::now() + kFollowerPatience);
  followers_->Read(
      *id, *min_revision, end,
      [this, id = *id, asking, check = std::move(check)](const absl::StatusOr<HostPtr>& host) {
        // Null: no other server has it.
        if (!host.ok() || *host != nullptr) return check(host);
        Open(MeshName(id), asking, check);
      });
}

void MeshRegistry::HandOver(absl::Duration limit) {
  if (followers_ == nullptr) return;
  followers_->Settle();
  if (config_.followers == 0) return;
  std::vector<OwnedHost> meshes;
  {
    const MutexLock lock(mutex_);
    for (const auto& [id, kept] : hosts_) {
      if (kept.host != nullptr && !kept.host->disowned()) meshes.push_back({kept.host, kept.key});
    }
  }
  HandMeshesOver(shared_, address_, meshes, limit);
}

std::vector<Followers::Followed> MeshRegistry::Followed() const {
  return followers_ == nullptr ? std::vector<Followers::Followed>() : followers_->List();
}

absl::StatusOr<std::vector<MeshRegistry::Listed>> MeshRegistry::ListAll(
    absl::string_view after, std::size_t limit,
    const std::function<bool(absl::string_view)>& shown) const {
  std::vector<Listed> listed;
  std::string last(after);
  while (true) {
    const absl::StatusOr<std::vector<SharedJournal::Located>> all = shared_->LocateAll(last, kPage);
    if (!all.ok()) {
      return absl::Status(all.status().code(),
                          absl::StrCat("the meshes cannot be listed: ", all.status().message()));
    }
    for (const SharedJournal::Located& located : *all) {
      const std::string& id = last = located.mesh.id;
      if (listed.size() == limit) return listed;
      if (shown != nullptr && !shown(id)) continue;
      listed.push_back(ListedOf(located));
    }
    if (all->size() < kPage) return listed;
  }
}

MeshRegistry::Listed MeshRegistry::ListedOf(const SharedJournal::Located& located) const {
  {
    const MutexLock lock(mutex_);
    const auto it = hosts_.find(located.mesh.id);
    if (it != hosts_.end() && (it->second.host == nullptr || !it->second.host->disowned())) {
      return {it->first, it->second.host, it->second.damage, "", 0, {}};
    }
  }
  const auto made = codec::DecodeJournalMesh(located.mesh.description);
  if (!located.mesh.damage.ok() || !made.ok()) {
    const absl::Status& why = located.mesh.damage.ok() ? made.status() : located.mesh.damage;
    return {located.mesh.id, nullptr, DamageOf(located.mesh.id, why), "", 0, {}};
  }
  const bool is_held = located.left > absl::ZeroDuration() && !located.address.empty();
  return {located.mesh.id,  nullptr,          absl::OkStatus(), is_held ? located.address : "none",
          located.revision, made->create_time};
}

absl::StatusOr<Journal::Key> MeshRegistry::KeyElsewhere(const std::string& id) const {
  const absl::Status missing = MeshNotFoundError(id);
  if (shared_ == nullptr) return missing;
  const absl::StatusOr<SharedJournal::Located> located = shared_->Locate(id);
  if (absl::IsNotFound(located.status())) return missing;
  if (!located.ok()) return JournalReadError(located.status(), id);
  if (located->is_mine || located->left <= absl::ZeroDuration()) return located->mesh.key;
  return NotOwnerError(id, {located->address, located->epoch});
}

void MeshRegistry::FindMade(const absl::StatusOr<HostPtr>& created, const MeshOptions& options,
                            const std::string& request_id, const Asking& asking,
                            MeshOpener::Done done) {
  const auto error = codec::GetServiceError(created.status());
  if (opener_ == nullptr || request_id.empty() || !error.has_value() ||
      error->reason != codec::reason::kMeshExists) {
    return done(created);
  }
  Open(error->metadata.at("mesh"), asking,
       [=, this, done = std::move(done)](const absl::StatusOr<HostPtr>& opened) {
         if (!opened.ok()) return done(opened);
         absl::StatusOr<HostPtr> made = HostPtr();
         {
           const MutexLock lock(mutex_);
           made = FindCreated((*opened)->id(), options, request_id);
         }
         const bool is_other = made.ok() && *made == nullptr;
         done(is_other ? created : made);
       });
}

absl::StatusOr<MeshRegistry::HostPtr> MeshRegistry::LoadShared(const Journal::Mesh& mesh) {
  {
    // Waits for a mesh that is being made: it is in the journal before it is here.
    const MutexLock changing(changing_mutex_);
    const MutexLock lock(mutex_);
    const auto it = hosts_.find(mesh.id);
    if (it != hosts_.end() && it->second.key == mesh.key && it->second.host != nullptr &&
        !it->second.host->disowned()) {
      return it->second.host;
    }
  }
  const absl::Time start = absl::Now();
  const absl::StatusOr<HostPtr> followed =
      followers_->TakeOver(mesh, [this, &mesh] { return journal_->Claim(mesh.key); });
  if (followed.ok() && *followed != nullptr) {
    PutFollowed(mesh, *followed, start);
    return followed;
  }
  absl::StatusOr<RecoveredMesh> found =
      followed.ok() ? RecoverMesh(*journal_, mesh, factory_, HostOptions(), [] {})
                    : absl::StatusOr<RecoveredMesh>(followed.status());
  if (found.ok()) return Put(mesh, *std::move(found), start);
  const absl::Status& why = found.status();
  if (absl::IsAborted(why)) return why;
  if (absl::IsNotFound(why)) return JournalError(why, mesh.id);
  if (absl::IsUnavailable(why)) {
    Log(LogLevel::kWarning, "not_opened",
        {{"mesh", mesh.id},
         {"error", why.message()},
         {"milliseconds", absl::ToInt64Milliseconds(absl::Now() - start)},
         {"message", "it is read again at the next call"}});
    return JournalReadError(why, mesh.id);
  }
  Log(LogLevel::kError, "mesh_damaged", {{"mesh", mesh.id}, {"error", why.message()}});
  const absl::Status damage = DamageOf(mesh.id, why);
  const MutexLock lock(mutex_);
  hosts_.insert_or_assign(mesh.id, Kept{nullptr, damage, mesh.key, {}});
  return damage;
}

void MeshRegistry::PutFollowed(const Journal::Mesh& mesh, const HostPtr& host, absl::Time start) {
  const auto made = codec::DecodeJournalMesh(mesh.description);
  const std::string request_id = made.ok() ? made->request_id : "";
  Log(LogLevel::kInfo, "taken_over",
      {{"mesh", mesh.id},
       {"revision", host->head().revision},
       {"hash", host->head().hash.ToHex()},
       {"milliseconds", absl::ToInt64Milliseconds(absl::Now() - start)}});
  const MutexLock lock(mutex_);
  if (!request_id.empty()) made_.emplace(request_id, mesh.id);
  hosts_.insert_or_assign(mesh.id, Kept{host, absl::OkStatus(), mesh.key, request_id});
}

absl::Status MeshRegistry::CheckRead(absl::string_view id) const {
  if (reads_ == nullptr || reads_()) return absl::OkStatus();
  return UnconfirmedError(id);
}

void MeshRegistry::CloseOpening(const absl::Status& status) {
  if (opener_ != nullptr) opener_->Close(status);
}

std::int64_t MeshRegistry::EpochOf(const std::string& id) const {
  if (shared_ == nullptr) return 0;
  Journal::Key key = 0;
  {
    const MutexLock lock(mutex_);
    const auto it = hosts_.find(id);
    if (it == hosts_.end()) return 0;
    key = it->second.key;
  }
  return shared_->EpochOf(key);
}

}  // namespace dynmesh::server
