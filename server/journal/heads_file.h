// The record of what was acknowledged, kept beside the database and its log. For each mesh
// journal.heads has its last revision, the checksum of that entry's row, and the number of answered
// requests with ids. It shows what each mesh lost if the log is damaged, cut or missing, or if the
// database is a copy without its log.
//
// When a mesh is made or edited, the record is written after the commit is on the disk, and before
// the acknowledgement. If the process is killed in between, the record is behind the journal: that
// is no loss. It is never ahead of the commits. When a mesh is deleted, the record is written and
// synced before the commit: the state "being deleted" is valid with both outcomes.
//
// A separate thread syncs the file, at most once a second. A commit does not sync it; it costs one
// or two writes of 128 bytes into the page cache. So after any end of the process the file is
// complete; after a loss of power it may lack the last second. With one sync per commit no file can
// do better: without a second sync the disk cannot tell whether the last transaction was
// acknowledged or torn while it was written.
//
// Layout: blocks of 4096 bytes with 32 slots of 128. Each block has two adjacent copies. A slot is
// written to its copies alternately, so that the older content survives a torn write. Slot 0 is the
// header: the journal's id, the log's salt and its number of frames. Numbers are little-endian.
// Each slot has a checksum over its position and its bytes. The layout never changes without a new
// magic number.
//
// Thread-safe, except Stage, Drop and Publish: these are for the thread that writes the journal.
#ifndef DYNMESH_SERVER_JOURNAL_HEADS_FILE_H_
#define DYNMESH_SERVER_JOURNAL_HEADS_FILE_H_

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"

namespace dynmesh::server {

class HeadsFile {
 public:
  using Key = std::int64_t;  // Journal::Key

  enum class State : std::uint8_t {
    kThere = 1,
    kDeleting = 2,     // or deleted
    kUnconfirmed = 3,  // created from a journal in doubt: something may be missing
  };
  struct Head {
    Key key = 0;
    std::string id;              // its first 63 bytes at most
    std::uint64_t revision = 0;  // the last one
    std::int64_t sum = 0;        // checksum of its entry; 0: none
    std::int64_t requests = 0;   // number of the last one
    State state = State::kThere;
    bool operator==(const Head&) const = default;
  };
  // How many frames of SQLite's log with this salt were committed.
  struct Position {
    std::uint64_t salt = 0;
    std::uint64_t frames = 0;
  };
  // A journal without this file is taken over: it does not have the id yet, nor the meshes their
  // slots.
  enum class Taking : std::uint8_t { kNo = 0, kYes = 1, kInDoubt = 2 };
  static constexpr std::size_t kIdBytes = 16, kMaxNameBytes = 63;
  static constexpr char kFileName[] = "journal.heads";

  // NOT_FOUND; DATA_LOSS if the header is unreadable; UNAVAILABLE.
  static absl::StatusOr<std::unique_ptr<HeadsFile>> Open(const std::string& folder);
  // Replaces the file atomically, synced.
  static absl::StatusOr<std::unique_ptr<HeadsFile>> Make(const std::string& folder,
                                                         const std::string& journal,
                                                         const std::vector<Head>& heads,
                                                         Taking taking);
  // Syncs.
  ~HeadsFile();

  const std::string& journal() const { return journal_; }  // kIdBytes
  Taking taking() const;
  // Marks the take-over as done, durably.
  absl::Status TookOver();
  Position position() const;
  std::size_t unreadable() const { return unreadable_; }  // slots, at Open
  // Each mesh with a key up to this one had a slot on the disk or was deleted.
  Key confirmed() const;
  // The greatest key in the file.
  Key greatest() const;
  std::vector<Head> Heads() const;  // by key

  // Changes of a transaction: staged, then published after the commit, or dropped. StageEntry and
  // StageRequest ignore unknown meshes.
  void Stage(const Head& head);
  void StageEntry(Key mesh, std::uint64_t revision, std::int64_t sum);
  void StageRequest(Key mesh, std::int64_t number);
  void Drop() { staged_.clear(); }
  // A failed write is logged once, and retried with the next Publish.
  void Publish(const Position& position);

  // Immediate, not durable; UNAVAILABLE.
  absl::Status Put(const Head& head);
  absl::Status Forget(Key mesh);
  // Durable: marks a known mesh as being deleted.
  absl::Status BeginDelete(Key mesh);
  // The mesh is deleted. After a failed deletion it is not called: the next start finds out the
  // outcome.
  void EndDelete(Key mesh);
  absl::Status Sync();

 private:
  struct Slot {
    Head head;     // key 0: free
    int copy = 0;  // the copy written last
  };
  explicit HeadsFile(int file) : file_(file), slots_(1) {}

  Head* Staged(Key mesh);
  absl::Status Load() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool LoadHeader(const std::string& bytes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void LoadSlot(std::size_t slot, const std::string& bytes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void StartSyncing();
  void Run();
  absl::Status Write(std::size_t slot, const std::string& content)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status WriteHeader() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status WriteHead(std::size_t slot) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status PutNow(const Head& head) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status ForgetNow(Key mesh) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Without the mutex while the disk works.
  absl::Status SyncNow() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Told(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const int file_;
  std::string journal_;
  std::size_t unreadable_ = 0;
  std::vector<Head> staged_;

  mutable Mutex mutex_;
  Taking taking_ ABSL_GUARDED_BY(mutex_) = Taking::kNo;
  Position position_ ABSL_GUARDED_BY(mutex_);
  Key confirmed_ ABSL_GUARDED_BY(mutex_) = 0, greatest_ ABSL_GUARDED_BY(mutex_) = 0;
  std::uint64_t sequence_ ABSL_GUARDED_BY(mutex_) = 0;         // of the last write
  std::vector<Slot> slots_ ABSL_GUARDED_BY(mutex_);            // the first is the header
  std::vector<std::size_t> free_ ABSL_GUARDED_BY(mutex_);      // free slots
  std::map<Key, std::size_t> places_ ABSL_GUARDED_BY(mutex_);  // slots by mesh
  std::set<std::size_t> unwritten_ ABSL_GUARDED_BY(mutex_);    // slots with a failed write
  bool failing_ ABSL_GUARDED_BY(mutex_) = false;

  CondVar wake_;
  bool dirty_ ABSL_GUARDED_BY(mutex_) = false, stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_HEADS_FILE_H_
