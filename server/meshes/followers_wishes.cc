// The part of Followers that chooses meshes: what this node asks others to follow, what it is asked
// to, and until when.
#include <algorithm>
#include <string>
#include <vector>

#include "server/base/log.h"
#include "server/base/mesh_name.h"
#include "server/cluster/placement.h"
#include "server/meshes/followers.h"

namespace dynmesh::server {

bool Followers::IsInUse(const Owned& mesh) {
  const Clock::time_point now = Clock::now();
  const auto [it, is_new] = seen_.try_emplace(mesh.key);
  Seen& seen = it->second;
  if (is_new || seen.revision != mesh.revision) seen.changed = now;
  seen.revision = mesh.revision;
  seen.look = looks_;
  return now - seen.changed < options_.idle;
}

void Followers::Ask() {
  ++looks_;
  std::vector<SharedJournal::Wish> wishes;
  absl::StatusOr<std::vector<std::string>> nodes;
  for (const Owned& mesh : calls_.owned()) {
    if (!IsInUse(mesh)) continue;
    if (wishes.empty()) nodes = journal_->LiveNodes();
    if (!nodes.ok()) return;
    wishes.push_back({mesh.key, NextNodes(*nodes, address_, mesh.id, options_.per_mesh)});
  }
  std::erase_if(seen_, [now = looks_](const auto& seen) { return seen.second.look != now; });
  // What fails is tried again soon.
  if (!wishes.empty()) journal_->AskToFollow(wishes).IgnoreError();
}

void Followers::TakeWishes() {
  const absl::StatusOr<std::vector<std::string>> asked = journal_->AskedToFollow();
  if (!asked.ok()) return;
  const MutexLock lock(mutex_);
  for (const auto& [id, follower] : by_id_) follower->wanted = false;
  for (const std::string& id : *asked) {
    const auto it = by_id_.find(id);
    FollowerPtr follower = it == by_id_.end() ? nullptr : it->second;
    if (follower == nullptr && by_id_.size() < options_.max_meshes) follower = AddLocked(id);
    if (follower != nullptr) follower->wanted = true;
  }
}

void Followers::DropUnused(Clock::time_point now) {
  std::vector<FollowerPtr> unused;
  {
    const MutexLock lock(mutex_);
    for (const auto& [id, follower] : by_id_) {
      if (follower->busy || follower->taking) continue;
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
