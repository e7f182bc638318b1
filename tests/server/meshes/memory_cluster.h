// A database in memory that several nodes share, each with a journal of its own: leases that end
// when a test says so, and rows that a test may change. No invariant is checked but the epoch.
// Thread-safe.
#ifndef DYNMESH_TESTS_SERVER_MESHES_MEMORY_CLUSTER_H_
#define DYNMESH_TESTS_SERVER_MESHES_MEMORY_CLUSTER_H_

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/journal/journal.h"
#include "server/journal/journal_errors.h"
#include "server/journal/shared_journal.h"

namespace dynmesh::server {

class MemoryCluster {
 public:
  struct Mesh {
    Journal::Mesh mesh;
    std::int64_t epoch = 1;
    std::string owner;    // its address
    bool leased = true;   // else free
    bool handed = false;  // and not claimed since
    std::uint64_t first;  // the entries' first revision is the next one
    std::vector<Journal::Entry> entries;
    std::vector<Journal::Request> requests;
    std::uint64_t snapshot = 0;
    std::vector<std::string> parts;
    std::set<std::string> followers, asked;
  };

  // Changes a mesh, or looks at it.
  void With(const std::string& id, const std::function<void(Mesh&)>& change) {
    const std::lock_guard lock(mutex_);
    change(meshes_.at(id));
  }
  void Free(const std::string& id) {
    With(id, [](Mesh& mesh) { mesh.leased = false; });
  }
  std::string OwnerOf(const std::string& id) {
    const std::lock_guard lock(mutex_);
    const Mesh& mesh = meshes_.at(id);
    return mesh.leased ? mesh.owner : "";
  }
  // How many meshes there were at the same time that were handed over and not claimed yet.
  int most_handed() {
    const std::lock_guard lock(mutex_);
    return most_handed_;
  }
  // Calls of ReadTails fail from now on, or work again.
  void Fail(bool fails) {
    const std::lock_guard lock(mutex_);
    fails_ = fails;
  }

  class Node final : public Journal, public SharedJournal {
   public:
    Node(MemoryCluster* cluster, std::string address)
        : cluster_(*cluster), address_(std::move(address)) {
      const std::lock_guard lock(cluster_.mutex_);
      cluster_.nodes_.push_back(address_);
    }

    std::string name() const override { return "memory"; }
    SharedJournal* shared() override { return this; }
    absl::StatusOr<std::vector<Journal::Mesh>> List() override {
      return absl::UnimplementedError("");
    }
    absl::StatusOr<Key> Create(const std::string& id, const std::string& description) override {
      const std::lock_guard lock(cluster_.mutex_);
      if (cluster_.meshes_.contains(id)) return MeshExists(id);
      MemoryCluster::Mesh mesh;
      mesh.mesh.key = ++cluster_.keys_;
      mesh.mesh.id = id;
      mesh.mesh.description = description;
      mesh.owner = address_;
      mesh.first = 0;
      cluster_.meshes_[id] = mesh;
      epochs_[mesh.mesh.key] = 1;
      return mesh.mesh.key;
    }
    absl::Status Claim(Key key) override {
      const std::lock_guard lock(cluster_.mutex_);
      MemoryCluster::Mesh* const mesh = cluster_.Find(key);
      if (mesh == nullptr) return NoSuchMesh();
      if (mesh->leased && mesh->owner != address_) return absl::AbortedError("leased");
      mesh->owner = address_;
      mesh->leased = true;
      mesh->handed = false;
      epochs_[key] = ++mesh->epoch;
      return absl::OkStatus();
    }
    absl::Status Delete(Key key) override {
      const std::lock_guard lock(cluster_.mutex_);
      std::erase_if(cluster_.meshes_, [key](const auto& m) { return m.second.mesh.key == key; });
      return absl::OkStatus();
    }
    bool Sweep(Key) override { return false; }
    using Journal::Append;
    absl::Status Append(Key key, const std::vector<Entry>& entries,
                        const std::vector<Request>& requests) override {
      const std::lock_guard lock(cluster_.mutex_);
      MemoryCluster::Mesh* const mesh = cluster_.Find(key);
      if (mesh == nullptr) return NoSuchMesh();
      if (mesh->epoch != epochs_[key]) return absl::AbortedError("fenced");
      mesh->entries.insert(mesh->entries.end(), entries.begin(), entries.end());
      mesh->requests.insert(mesh->requests.end(), requests.begin(), requests.end());
      return absl::OkStatus();
    }
    absl::Status Read(Key key, const Visitor& visitor) override {
      MemoryCluster::Mesh mesh;
      {
        const std::lock_guard lock(cluster_.mutex_);
        const MemoryCluster::Mesh* const found = cluster_.Find(key);
        if (found == nullptr) return NoSuchMesh();
        mesh = *found;
        ++reads_;
      }
      absl::Status status;
      for (const Request& request : mesh.requests) {
        if (status.ok()) status = visitor.request(request);
      }
      for (const std::string& part : mesh.parts) {
        if (status.ok()) status = visitor.snapshot(mesh.snapshot, part);
      }
      for (const Entry& entry : mesh.entries) {
        if (status.ok() && entry.revision > mesh.snapshot) status = visitor.entry(entry);
      }
      return status;
    }
    absl::Status ReadPast(Key, std::uint64_t, std::uint64_t, const Visitor&) override {
      return absl::UnimplementedError("");
    }
    absl::StatusOr<std::uint64_t> Oldest(Key) override { return 0; }
    using Journal::Compact;
    absl::Status Compact(Key key, std::uint64_t revision, const std::vector<std::string>& parts,
                         const std::atomic<bool>&) override {
      const std::lock_guard lock(cluster_.mutex_);
      MemoryCluster::Mesh* const mesh = cluster_.Find(key);
      mesh->snapshot = revision;
      mesh->parts = parts;
      return absl::OkStatus();
    }

    absl::Duration lease() const override { return absl::Hours(1); }
    absl::StatusOr<std::vector<Key>> Renew(const std::string&) override {
      const std::lock_guard lock(cluster_.mutex_);
      std::vector<Key> mine;
      for (const auto& [id, mesh] : cluster_.meshes_) {
        if (mesh.leased && mesh.owner == address_) mine.push_back(mesh.mesh.key);
      }
      std::sort(mine.begin(), mine.end());
      return mine;
    }
    absl::Status GiveUp() override {
      const std::lock_guard lock(cluster_.mutex_);
      std::erase(cluster_.nodes_, address_);
      for (auto& [id, mesh] : cluster_.meshes_) {
        if (mesh.owner == address_) mesh.leased = false;
      }
      return absl::OkStatus();
    }
    absl::StatusOr<std::vector<std::string>> LiveNodes() override {
      const std::lock_guard lock(cluster_.mutex_);
      return cluster_.nodes_;
    }
    absl::StatusOr<Located> Locate(const std::string& id) override {
      const std::lock_guard lock(cluster_.mutex_);
      const auto it = cluster_.meshes_.find(id);
      if (it == cluster_.meshes_.end()) return NoSuchMesh();
      Located located = LocatedOf(it->second);
      located.followers.assign(it->second.followers.begin(), it->second.followers.end());
      return located;
    }
    absl::StatusOr<std::vector<Located>> LocateAll(const std::string& after,
                                                   std::size_t limit) override {
      const std::lock_guard lock(cluster_.mutex_);
      std::vector<Located> all;
      for (auto it = cluster_.meshes_.upper_bound(after);
           it != cluster_.meshes_.end() && all.size() < limit; ++it) {
        all.push_back(LocatedOf(it->second));
      }
      return all;
    }
    std::int64_t EpochOf(Key key) override {
      const std::lock_guard lock(cluster_.mutex_);
      return epochs_[key];
    }
    absl::StatusOr<std::vector<Tail>> ReadTails(const std::vector<Position>& positions) override {
      const std::lock_guard lock(cluster_.mutex_);
      if (cluster_.fails_) return absl::UnavailableError("no connection");
      std::vector<Tail> tails;
      for (const Position& position : positions) tails.push_back(TailOf(position));
      return tails;
    }
    absl::Status AskToFollow(const std::vector<Wish>& wishes) override {
      const std::lock_guard lock(cluster_.mutex_);
      for (const Wish& wish : wishes) {
        MemoryCluster::Mesh* const mesh = cluster_.Find(wish.mesh);
        if (mesh != nullptr) mesh->asked = {wish.addresses.begin(), wish.addresses.end()};
      }
      return absl::OkStatus();
    }
    absl::StatusOr<std::vector<std::string>> AskedToFollow() override {
      const std::lock_guard lock(cluster_.mutex_);
      std::vector<std::string> ids;
      for (const auto& [id, mesh] : cluster_.meshes_) {
        if (mesh.asked.contains(address_) && mesh.owner != address_) ids.push_back(id);
      }
      return ids;
    }
    absl::Status SetFollows(Key key, bool follows) override {
      const std::lock_guard lock(cluster_.mutex_);
      MemoryCluster::Mesh* const mesh = cluster_.Find(key);
      if (mesh != nullptr && follows) mesh->followers.insert(address_);
      if (mesh != nullptr && !follows) {
        mesh->followers.erase(address_);
        mesh->asked.erase(address_);
      }
      return absl::OkStatus();
    }
    absl::StatusOr<std::int64_t> HandOver(Key key, const std::string& address) override {
      const std::lock_guard lock(cluster_.mutex_);
      MemoryCluster::Mesh* const mesh = cluster_.Find(key);
      if (mesh == nullptr || mesh->epoch != epochs_[key]) {
        return absl::FailedPreconditionError("not this node's");
      }
      mesh->owner = address;
      mesh->handed = true;
      const auto handed = std::count_if(cluster_.meshes_.begin(), cluster_.meshes_.end(),
                                        [](const auto& m) { return m.second.handed; });
      cluster_.most_handed_ = std::max(cluster_.most_handed_, static_cast<int>(handed));
      epochs_[key] = 0;
      return ++mesh->epoch;
    }

    // How often a mesh was read from its snapshot.
    int reads() const {
      const std::lock_guard lock(cluster_.mutex_);
      return reads_;
    }

   private:
    static std::uint64_t HeadOf(const MemoryCluster::Mesh& mesh) {
      return mesh.entries.empty() ? mesh.first : mesh.entries.back().revision;
    }
    Located LocatedOf(const MemoryCluster::Mesh& mesh) const {
      Located located;
      located.mesh = mesh.mesh;
      located.revision = HeadOf(mesh);
      located.is_mine = mesh.owner == address_;
      located.address = mesh.owner;
      located.epoch = mesh.epoch;
      located.left = mesh.leased ? absl::Hours(1) : absl::ZeroDuration();
      return located;
    }
    Tail TailOf(const Position& position) const {
      Tail tail;
      tail.mesh = position.mesh;
      const MemoryCluster::Mesh* const mesh = cluster_.Find(position.mesh);
      if (mesh == nullptr) return tail;
      tail.exists = true;
      tail.head = HeadOf(*mesh);
      tail.answers = static_cast<std::int64_t>(mesh->requests.size());
      tail.snapshot = mesh->snapshot;
      tail.is_mine = mesh->owner == address_;
      tail.is_free = !mesh->leased;
      tail.address = mesh->owner;
      tail.epoch = mesh->epoch;
      for (const Entry& entry : mesh->entries) {
        if (entry.revision > position.revision) tail.entries.push_back(entry);
      }
      if (!tail.entries.empty() && tail.entries.front().revision != position.revision + 1) {
        tail.damage = absl::OutOfRangeError("compacted");
        tail.entries.clear();
      }
      for (std::int64_t n = position.answers; n < tail.answers; ++n) {
        tail.requests.push_back(mesh->requests[static_cast<std::size_t>(n)]);
      }
      return tail;
    }

    MemoryCluster& cluster_;
    const std::string address_;
    std::map<Key, std::int64_t> epochs_;
    int reads_ = 0;
  };

 private:
  Mesh* Find(Journal::Key key) {
    for (auto& [id, mesh] : meshes_) {
      if (mesh.mesh.key == key) return &mesh;
    }
    return nullptr;
  }

  std::mutex mutex_;
  std::map<std::string, Mesh> meshes_;
  std::vector<std::string> nodes_;
  Journal::Key keys_ = 0;
  int most_handed_ = 0;
  bool fails_ = false;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_MESHES_MEMORY_CLUSTER_H_
