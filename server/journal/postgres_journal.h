// The journal in a PostgreSQL database, which several servers may use: each mesh belongs to the
// journal object that claimed it last (postgres_ownership.h). The database brings durability, also
// that of synchronous standbys; this class brings that each append ends with one of the three
// outcomes and is never made twice.
//
// An append is one statement, in a transaction of its own (postgres_append.h). If the connection is
// lost meanwhile, or the server warns that a standby did not confirm the commit, the outcome is
// unknown at first. The mesh is then claimed again on another connection, which tells. If the group
// is not there, it is appended again. If the time for that ends, the outcome stays unknown and the
// mesh is disowned. With leases it ends when the mesh's lease has: another server can have the mesh
// then, and clients find out there.
//
// Snapshots and deletions go in parts, as in SQLite. Leftovers of an interrupted sequence are
// deleted at the mesh's next snapshot, or, of a deleted mesh, when the journal is opened.
//
// Cost: a round trip and a commit per append; commits of several meshes are shared by the database.
// Concurrent calls have connections of their own. Thread-safe.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_JOURNAL_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_JOURNAL_H_

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/journal/journal.h"
#include "server/journal/mesh_import.h"
#include "server/journal/open_postgres.h"
#include "server/journal/postgres_append.h"
#include "server/journal/postgres_ownership.h"
#include "server/journal/postgres_pool.h"
#include "server/journal/postgres_target.h"
#include "server/journal/shared_journal.h"
#include "server/journal/writes_under_way.h"

namespace dynmesh::server {

class PostgresJournal final : public Journal, public SharedJournal, public MeshImport {
 public:
  using Options = PostgresOptions;

  // As OpenPostgresJournal.
  static absl::StatusOr<std::unique_ptr<PostgresJournal>> Open(const std::string& url,
                                                               const Options& options);

  std::string name() const override { return name_; }
  Counts counts() const override {
    return {commits_.load(), failures_.load(),   failing_.load(), fenced_.load(), unknown_.load(),
            false,           under_way_.Oldest()};
  }
  void EndWrites(const absl::Status& why) override { under_way_.End(why); }
  SharedJournal* shared() override { return is_shared() ? this : nullptr; }
  // As of the opening, or of the last snapshot of any mesh since.
  std::uint64_t bytes() const override { return bytes_; }
  absl::StatusOr<std::vector<Mesh>> List() override;
  absl::StatusOr<Key> Create(const std::string& id, const std::string& description) override;
  absl::Status Claim(Key mesh) override;
  absl::Status Delete(Key mesh) override;
  bool Sweep(Key mesh) override;
  using Journal::Append;
  absl::Status Append(Key mesh, const std::vector<Entry>& entries,
                      const std::vector<Request>& requests) override;
  absl::Status Read(Key mesh, const Visitor& visitor) override;
  absl::Status ReadPast(Key mesh, std::uint64_t from, std::uint64_t to,
                        const Visitor& visitor) override;
  absl::StatusOr<std::uint64_t> Oldest(Key mesh) override;
  using Journal::Compact;
  absl::Status Compact(Key mesh, std::uint64_t revision, const std::vector<std::string>& parts,
                       const std::atomic<bool>& cancelled) override;

  // With leases (postgres_shared.cc).
  absl::Duration lease() const override { return options_.lease; }
  absl::StatusOr<std::vector<Key>> Renew(const std::string& address) override;
  absl::Status GiveUp() override;
  absl::StatusOr<std::vector<std::string>> LiveNodes() override;
  absl::StatusOr<Located> Locate(const std::string& id) override;
  absl::StatusOr<std::vector<Located>> LocateAll(const std::string& after,
                                                 std::size_t limit) override;
  std::int64_t EpochOf(Key mesh) override;
  absl::StatusOr<std::vector<Tail>> ReadTails(const std::vector<Position>& positions) override;
  absl::Status AskToFollow(const std::vector<Wish>& wishes) override;
  absl::StatusOr<std::vector<std::string>> AskedToFollow() override;
  absl::Status SetFollows(Key mesh, bool follows) override;
  absl::StatusOr<std::int64_t> HandOver(Key mesh, const std::string& address) override;

  // Meshes from other journals (postgres_import.cc).
  MeshImport* import() override { return this; }
  absl::StatusOr<Key> NewKey() override;
  absl::Status WriteUnseen(Key mesh, const std::vector<Part>& parts,
                           const std::vector<Entry>& entries) override;
  absl::Status Publish(Key mesh, const Whole& whole) override;

 private:
  // A mesh that this object claimed.
  struct Owned {
    // `sent`: when the claim was, as BootTime.
    Owned(const postgres::Belief& belief, std::chrono::nanoseconds sent)
        : is(belief), epoch(belief.epoch), claimed(sent) {}

    Mutex mutex;                                 // held during an append
    absl::Status gone ABSL_GUARDED_BY(mutex);    // not OK: disowned, and why
    postgres::Belief is ABSL_GUARDED_BY(mutex);  // while it is owned
    std::atomic<std::int64_t> epoch;             // as in `is`; 0: disowned. Without the mutex
    std::chrono::nanoseconds claimed ABSL_GUARDED_BY(mutex);
  };
  using OwnedPtr = std::shared_ptr<Owned>;

  PostgresJournal(const postgres::Target& target, const Options& options);

  bool is_shared() const { return options_.lease > absl::ZeroDuration(); }
  // One claim, forced or of a free mesh.
  postgres::Claimed ClaimOn(postgres::Session& session, Key mesh) const;
  absl::Status ClaimNow(Key mesh);
  OwnedPtr Find(Key mesh);
  void Keep(Key mesh, const postgres::Belief& belief, std::chrono::nanoseconds claimed);
  // Counts a writing call by its status, and returns it.
  absl::Status Counted(absl::Status status);
  // Runs `step` on a connection. If its outcome is unknown, runs it again on another one, for the
  // time that options allow, with leases for one; so it must have the same effect when it is
  // repeated. `is_unknown` is set to whether the outcome still is unknown at the end.
  using Step = std::function<absl::Status(postgres::Session& session, bool* unknown)>;
  absl::Status Repeatedly(const Step& step, bool* is_unknown = nullptr);
  // The same for a change that clients see: UNKNOWN if its outcome was not found out.
  absl::Status Change(const Step& step);

  absl::Status AppendGroup(Key mesh, Owned& owned, const postgres::GroupAppend& group)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(owned.mutex);
  absl::Status Resolve(Key mesh, Owned& owned, const postgres::GroupAppend& group,
                       std::chrono::nanoseconds end, bool* is_there)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(owned.mutex);
  // With leases: how long this server certainly has the mesh from now on; at most 0: another one
  // may have it.
  std::chrono::nanoseconds LeaseLeft(const Owned& owned) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(owned.mutex);
  // How long a new connection is waited for; `owned`: the mesh whose outcome is looked for.
  std::chrono::nanoseconds Patience() const;
  std::chrono::nanoseconds Patience(const Owned& owned) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(owned.mutex);
  // Why nothing can be written to a mesh that this object never claimed.
  absl::Status NotClaimed(Key mesh);
  absl::Status Disown(Owned& owned, absl::Status why) ABSL_EXCLUSIVE_LOCKS_REQUIRED(owned.mutex);

  // Snapshots, without the mesh's mutex (postgres_snapshots.cc).
  absl::Status CompactIn(Key mesh, Owned& owned, std::uint64_t revision,
                         const std::vector<std::string>& parts, const std::atomic<bool>& cancelled);
  // Runs `work`, a transaction, in the mesh's present epoch; again if that changes meanwhile.
  absl::Status SnapshotStep(
      Owned& owned, std::uint64_t revision,
      const std::function<absl::Status(postgres::Session&, std::int64_t epoch)>& work);
  void SweepWhole(Key mesh, const std::atomic<bool>* cancelled = nullptr);
  // Draws a key, unless `*key` has one already.
  absl::Status DrawKey(postgres::Session& session, Key* key, bool* unknown) const;
  // Checks rights and settings, makes or renews the tables. The meshes whose rest is to be removed.
  absl::StatusOr<std::vector<std::int64_t>> Prepare(postgres::Session& session);
  void Measure(postgres::Session& session);

  const std::string name_;
  const Options options_;
  const std::string owner_;  // no other journal object has it
  postgres::Pool writers_, readers_;
  postgres::Pool keeper_;    // for leases, which must not wait for appends
  postgres::Pool follower_;  // for tails, which must not wait for long reads

  Mutex owned_mutex_;
  std::map<Key, OwnedPtr> owned_ ABSL_GUARDED_BY(owned_mutex_);
  WritesUnderWay under_way_;

  std::atomic<std::int64_t> renewed_{0};  // when the last renewal was sent, as BootTime
  std::atomic<std::uint64_t> commits_{0};
  std::atomic<std::uint64_t> failures_{0};
  std::atomic<std::uint64_t> fenced_{0}, unknown_{0};
  std::atomic<bool> failing_{false};
  std::atomic<std::uint64_t> bytes_{0};
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_JOURNAL_H_
