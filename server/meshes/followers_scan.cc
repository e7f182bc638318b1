// The part of Followers that chooses meshes: those in use that placement gives this node, until
// they are not used any more.
#include <algorithm>
#include <string>
#include <vector>

#include "server/base/log.h"
#include "server/base/mesh_name.h"
#include "server/cluster/placement.h"
#include "server/meshes/followers.h"

namespace dynmesh::server {

bool Followers::IsInUse(const SharedJournal::Place& place) {
  const Clock::time_point now = Clock::now();
  const auto [it, is_new] = seen_.try_emplace(place.mesh.key);
  Seen& seen = it->second;
  // What was there at the first scan may have been idle for long.
  const bool changed = is_new ? scans_ > 1 : seen.revision != place.revision;
  if (changed) {
    seen.used = now;
  } else if (is_new) {
    seen.used = now - options_.idle;
  }
  seen.revision = place.revision;
  seen.scan = scans_;
  return now - seen.used < options_.idle;
}

void Followers::Scan() {
  constexpr std::size_t kPage = 1'000;
  ++scans_;
  const absl::StatusOr<std::vector<std::string>> nodes = journal_->LiveNodes();
  if (!nodes.ok()) return;
  std::string after;
  while (true) {
    const auto places = journal_->LocateAll(after, kPage);
    if (!places.ok()) return;
    for (const SharedJournal::Place& place : *places) {
      after = place.mesh.id;
      const bool in_use = IsInUse(place);
      const bool is_other = !place.is_mine && place.left > absl::ZeroDuration();
      const bool wanted =
          in_use && is_other && place.mesh.damage.ok() &&
          IsAmongNext(*nodes, place.address, place.mesh.id, address_, options_.per_mesh);
      const std::lock_guard lock(mutex_);
      const auto it = by_id_.find(after);
      if (it != by_id_.end()) {
        it->second->wanted = wanted;
      } else if (wanted) {
        Follower probe;
        probe.mesh.key = place.mesh.key;
        const bool has_room = by_id_.size() < options_.max_meshes && CheckRoomLocked(probe).ok();
        if (const FollowerPtr added = has_room ? AddLocked(after) : nullptr; added != nullptr) {
          added->wanted = true;
        }
      }
    }
    if (places->size() < kPage) break;
  }
  std::erase_if(seen_, [this](const auto& seen) { return seen.second.scan != scans_; });
}

void Followers::DropUnused(Clock::time_point now) {
  std::vector<FollowerPtr> unused;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, follower] : by_id_) {
      if (follower->busy || follower->wanted || follower->taking) continue;
      if (follower->host->hub()->size() > 0) follower->used = now;
      if (now - follower->used >= options_.idle) unused.push_back(follower);
    }
  }
  for (const FollowerPtr& follower : unused) {
    Log(LogLevel::kInfo, "follows_no_more", {{"mesh", follower->id}});
    Drop(follower, NotOwnerError(follower->id, follower->owner));
  }
}

}  // namespace dynmesh::server
