// What was acknowledged, written down beside the database and its log: journal.heads has for each
// mesh its last revision with the checksum of that entry's row, and how many requests with ids were
// answered. If the log is damaged, cut or gone, or the database is a copy without it, this tells
// which mesh lost what.
//
// For a mesh that is made, and for an edit, it is written when the commit is on the disk, before
// that is acknowledged. A process that is killed in between leaves a file that says less than the
// journal has: no loss. It never says more than was committed. For a mesh that is deleted it is
// written, and synced, before the commit: "being deleted" fits both ends.
//
// The file is synced by a thread of its own, at most once a second, never by a commit, whose price
// is a write of 128 bytes or two into the page cache. So after the end of a process, however it
// came, the file has all; after a loss of power it may lack the last second. No file could do
// better with one sync for a commit: whether the last transaction was acknowledged, or was torn
// on its way, nothing on a disk tells that was not synced in between.
//
// Layout: blocks of 4096 bytes with 32 slots of 128. Each block is there twice, side by side, and
// slots are written to the one and the other by turns, so that what was written before is there
// if the last is not whole. Slot 0 is the header: the journal's id, and which log (salt) had how
// many frames. Numbers are little-endian; each slot has a checksum over its place and its bytes.
// Files keep the layout: it never changes but with the magic.
//
// Thread-safe, but Stage, Drop and Publish: for the thread that writes into the journal.
#ifndef DYNMESH_SERVER_JOURNAL_HEADS_FILE_H_
#define DYNMESH_SERVER_JOURNAL_HEADS_FILE_H_

#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace dynmesh::server {

class HeadsFile {
 public:
  using Key = std::int64_t;  // Journal::Key

  enum class State : std::uint8_t {
    kThere = 1,
    kDeleting = 2,     // or deleted
    kUnconfirmed = 3,  // taken over in doubt: something may be missing
  };
  struct Head {
    Key key = 0;
    std::string id;              // at most 63 bytes of it
    std::uint64_t revision = 0;  // the last one
    std::int64_t sum = 0;        // checksum of its entry; 0: none
    std::int64_t requests = 0;   // the number of the last
    State state = State::kThere;
    bool operator==(const Head&) const = default;
  };
  // Of SQLite's log: so many frames of the log with this salt were committed.
  struct Position {
    std::uint64_t salt = 0;
    std::uint64_t frames = 0;
  };
  // Of a journal that had no such file: it has not got the id yet, and its meshes no slots.
  enum class Taking : std::uint8_t { kNo = 0, kYes = 1, kInDoubt = 2 };
  static constexpr std::size_t kIdBytes = 16, kMaxNameBytes = 63;
  static constexpr char kFileName[] = "journal.heads";

  // NOT_FOUND; DATA_LOSS if not even the header can be read; UNAVAILABLE.
  static absl::StatusOr<std::unique_ptr<HeadsFile>> Open(const std::string& folder);
  // In the place of what is there, whole and synced or not at all.
  static absl::StatusOr<std::unique_ptr<HeadsFile>> Make(const std::string& folder,
                                                         const std::string& journal,
                                                         const std::vector<Head>& heads,
                                                         Taking taking);
  // Syncs.
  ~HeadsFile();

  const std::string& journal() const { return journal_; }  // kIdBytes
  Taking taking() const;
  // Durable.
  absl::Status TookOver();
  Position position() const;
  std::size_t unreadable() const { return unreadable_; }  // slots, when it was opened
  // Each mesh with a key up to this one had a slot on the disk, or was deleted.
  Key confirmed() const;
  // No key that the file knows of is greater.
  Key greatest() const;
  std::vector<Head> Heads() const;  // by key

  // Changes that belong to a transaction: staged, then published when it is committed, or dropped.
  // A mesh that is not known is passed over by the latter two.
  void Stage(const Head& head);
  void StageEntry(Key mesh, std::uint64_t revision, std::int64_t sum);
  void StageRequest(Key mesh, std::int64_t number);
  void Drop() { staged_.clear(); }
  // What cannot be written is logged, once, and tried again with the next.
  void Publish(const Position& position);

  // At once, not durable; UNAVAILABLE.
  absl::Status Put(const Head& head);
  absl::Status Forget(Key mesh);
  // Durable: marks a mesh that is known.
  absl::Status BeginDelete(Key mesh);
  // It is gone. A deletion that failed is not told: how it ended is known at the next start.
  void EndDelete(Key mesh);
  absl::Status Sync();

 private:
  struct Slot {
    Head head;     // key 0: free
    int copy = 0;  // that was written last
  };
  explicit HeadsFile(int file) : file_(file), slots_(1) {}

  Head* Staged(Key mesh);
  absl::Status Load();
  bool LoadHeader(const std::string& bytes);
  void LoadSlot(std::size_t slot, const std::string& bytes);
  void StartSyncing();
  void Run();
  // With the mutex held.
  absl::Status Write(std::size_t slot, const std::string& content);
  absl::Status WriteHeader();
  absl::Status WriteHead(std::size_t slot);
  absl::Status PutNow(const Head& head);
  absl::Status ForgetNow(Key mesh);
  absl::Status SyncNow(std::unique_lock<std::mutex>& lock);
  void Told(const absl::Status& status);

  const int file_;
  std::string journal_;
  std::size_t unreadable_ = 0;
  std::vector<Head> staged_;

  mutable std::mutex mutex_;
  Taking taking_ = Taking::kNo;
  Position position_;
  Key confirmed_ = 0, greatest_ = 0;
  std::uint64_t sequence_ = 0;         // of the last write
  std::vector<Slot> slots_;            // the first is the header's
  std::vector<std::size_t> free_;      // slots
  std::map<Key, std::size_t> places_;  // slots by mesh
  std::set<std::size_t> unwritten_;    // slots that could not be
  bool failing_ = false;

  std::condition_variable wake_;
  bool dirty_ = false, stopping_ = false;
  std::thread thread_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_HEADS_FILE_H_
