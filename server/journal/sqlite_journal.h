// The journal in a folder: an SQLite database in WAL mode, synced at every commit, and a lock.
//
// One caller at a time writes its own change and all that wait, in one transaction, so that they
// share a sync; the others wait. A failed transaction is rolled back and all its changes fail,
// since the state on the disk after a failed sync is unknown. Before anything else is written, a
// probe is written at the same place of the log. Until a probe succeeds, all writes fail.
//
// Large data is written and deleted in parts, each in a transaction of its own, between which
// other changes are written; a snapshot pauses there, so that it takes half of the time at most
// (sqlite_snapshots.cc). Leftovers of an interrupted sequence are not visible
// (sqlite_generations.h). They are deleted at the mesh's next snapshot or when the journal is
// opened.
//
// The files may go away while they are open (journal_presence.h). A group is committed only if they
// are there just before. Else it is rolled back and refused, nothing on the disk is in doubt, and
// writing goes on when they are back, without a probe. What was being committed at that moment is
// in the files that went.
//
// Cost: a sync per group, O(bytes) and a search in a B-tree. Reads have connections of their own
// and wait for no writer. Thread-safe.
#ifndef DYNMESH_SERVER_JOURNAL_SQLITE_JOURNAL_H_
#define DYNMESH_SERVER_JOURNAL_SQLITE_JOURNAL_H_

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/base/mutex.h"
#include "server/journal/checkpointer.h"
#include "server/journal/folder_lock.h"
#include "server/journal/heads_file.h"
#include "server/journal/journal.h"
#include "server/journal/journal_presence.h"
#include "server/journal/losses.h"
#include "server/journal/mesh_import.h"
#include "server/journal/opening.h"
#include "server/journal/sqlite.h"
#include "server/journal/writes_under_way.h"

namespace dynmesh::server {

class SqliteJournal final : public Journal, public MeshImport {
 public:
  struct Options {
    std::size_t remembered_requests = 10'000;  // of a mesh
    // Limit of a mesh's generations before the newest. The last of them is always kept.
    std::uint64_t history_bytes = 64 << 20;
    std::uint64_t transaction_bytes = 1 << 20;  // at most, or one row
    const char* vfs = nullptr;                  // of SQLite; for tests
    // Losses that the operator accepts, as in losses.h.
    std::vector<std::string> accept_loss;
  };

  // FAILED_PRECONDITION if another process has the folder, a newer version wrote it, or its files
  // do not belong together. Meshes with losses are listed, read only.
  static absl::StatusOr<std::unique_ptr<SqliteJournal>> Open(const std::string& folder,
                                                             const Options& options);
  ~SqliteJournal() override;

  std::string name() const override { return path_; }
  Counts counts() const override;
  void EndWrites(const absl::Status& why) override;
  std::uint64_t bytes() const override;
  absl::StatusOr<std::vector<Mesh>> List() override;
  absl::StatusOr<Key> Create(const std::string& id, const std::string& description) override;
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

  // Meshes from other journals (sqlite_import.cc).
  MeshImport* import() override { return this; }
  absl::StatusOr<Key> NewKey() override;
  absl::Status WriteUnseen(Key mesh, const std::vector<Part>& parts,
                           const std::vector<Entry>& entries) override;
  absl::Status Publish(Key mesh, const Whole& whole) override;

 private:
  // A change of one caller in a transaction. An error found before it wrote anything fails that
  // change only; an error of SQLite fails the whole group.
  using Change = std::function<absl::Status()>;
  struct Waiting {
    const Change* change;
    absl::Status result;
    bool done = false;
  };

  SqliteJournal(const std::string& folder, std::string path, const Options& options,
                FolderLock lock, OpenedJournal opened, sqlite::Connection mover);

  absl::Status Write(const Change& change);
  // DATA_LOSS if the mesh has a loss.
  absl::Status CheckWritable(Key mesh);
  bool TakeMissing(Key mesh);
  void AddLosses(std::vector<Mesh>* meshes);
  // The position in SQLite's log, after a transaction.
  HeadsFile::Position LogPosition();
  // Snapshots. OK if one can be made of that revision, or is there already.
  absl::Status CheckSnapshot(Key mesh, std::uint64_t revision, bool* there);
  absl::Status WriteSnapshot(Key mesh, std::uint64_t revision,
                             const std::vector<std::string>& parts,
                             const std::atomic<bool>& cancelled);
  void SweepSlowly(Key mesh, const std::atomic<bool>& cancelled);
  void SweepWhole(Key mesh);
  void SweepAll();
  // Called by the writing thread.
  void WriteAll() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // `refused` is set if the files are gone: nothing was handed to the disk.
  absl::Status Commit(const std::vector<Waiting*>& group, bool* refused);
  absl::Status Probe(bool* refused);
  // FAILED_PRECONDITION: `revision` does not follow the journal's `last`.
  absl::Status OutOfSequence(std::uint64_t revision, std::int64_t last);
  // MeshExists, or OK.
  absl::Status CheckNew(const std::string& id);
  absl::StatusOr<Key> InsertMesh(const std::string& id, const std::string& description);
  absl::StatusOr<std::int64_t> InsertEntry(Key mesh, const Entry& entry);  // returns its checksum
  absl::Status InsertRequest(Key mesh, std::int64_t number, const Request& request);
  // Of the mesh's rows in a table.
  absl::StatusOr<std::int64_t> CountOf(const char* sql, Key mesh);
  absl::Status InsertWhole(Key mesh, const Whole& whole);
  absl::Status AppendEntries(Key mesh, const std::vector<Entry>& entries);
  absl::Status AppendRequests(Key mesh, const std::vector<Request>& requests);
  // The mesh's last revision.
  absl::StatusOr<std::int64_t> LastOf(Key mesh);
  absl::Status Run(const char* sql, Key mesh);
  absl::StatusOr<sqlite::Connection> OpenReader();

  const std::string path_;
  const Options options_;
  const FolderLock lock_;

  const absl::Status sealed_;  // not OK: read only
  const bool has_losses_;      // when it was opened
  Mutex losses_mutex_;
  std::map<Key, Loss> losses_ ABSL_GUARDED_BY(losses_mutex_);

  // Used by the writing thread only.
  sqlite::Connection writer_;
  std::atomic<bool> failed_{false};
  int log_pages_ = 0;
  int position_pages_ = 0;  // when the log's salt was read
  std::uint64_t log_salt_ = 0;
  const std::unique_ptr<HeadsFile> heads_;
  JournalPresence presence_;

  std::atomic<std::uint64_t> syncs_{0};
  std::atomic<std::uint64_t> failures_{0};

  Mutex mutex_;
  CondVar ended_;  // a transaction ended
  std::vector<Waiting*> waiting_ ABSL_GUARDED_BY(mutex_);
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  WritesUnderWay under_way_;
  std::atomic<bool> told_of_another_{false};

  Checkpointer checkpointer_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_SQLITE_JOURNAL_H_
