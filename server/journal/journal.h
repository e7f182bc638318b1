// The persistent state: the meshes, and for each a snapshot of its features, the batches since, and
// the last answers to batches with a request_id. An interface; proto/codec/journal_codec.h defines
// the bytes.
//
// A snapshot and the batches up to the next one are a generation. A mesh is recovered from the
// newest generation. The previous one is kept, and more within a size limit, so that older
// revisions can be read: the mesh's history. The first generation begins at revision 0, without
// features.
//
// Invariants of an implementation:
//   1. a call that returned OK is durable: it survives the end of the process and a loss of power;
//   2. a call that returned an error has no visible effect while the journal is open.
//      (After a crash a failed change may turn out to have been made, completely.)
//   3. the entries of a mesh follow its oldest snapshot one by one, without a gap;
//   4. each row has a checksum: a damaged row gives DATA_LOSS with the mesh and the revision;
//   5. at opening, each mesh that lacks acknowledged data is detected, whatever was done to the
//      files, and becomes read only. (A journal in a database leaves that to the database.)
//   6. a mesh has at most one owner: the journal object that claimed it last, in any process. No
//      other can write to it;
//   7. nothing is acknowledged into files that are no longer found at the journal's path: while
//      they are not there, all writing calls fail. (A database has no such path.)
// Calls block until the disk is done; concurrent calls may share a sync. After a failed write all
// writing calls fail until a test write succeeds. Thread-safe.
//
// An append has one of three outcomes (OutcomeOf). *Appended*: OK. *Refused*: an error, and by
// invariant 2 nothing was written and nothing will be; the next append may succeed. *Disowned*:
// this object cannot write to the mesh any more, and each call for it fails in the same way until
// it is claimed again. ABORTED says that the mesh was *fenced*, as another object claimed it, and
// that nothing was written. UNKNOWN says that the connection was lost and that it could not be
// found out whether the append was written: it is there completely, not at all, or may still arrive
// until the next claim.
//
// Errors: UNAVAILABLE if it may be temporary (a full disk), DATA_LOSS if stored data is damaged,
// NOT_FOUND for a deleted mesh, FAILED_PRECONDITION for a revision out of sequence, OUT_OF_RANGE
// for a revision that does not exist or no longer exists; ABORTED and UNKNOWN as above.
#ifndef DYNMESH_SERVER_JOURNAL_JOURNAL_H_
#define DYNMESH_SERVER_JOURNAL_JOURNAL_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace dynmesh::server {

// The outcomes of an append.
enum class AppendOutcome { kAppended, kRefused, kFenced, kUnknown };

// The outcome that the status of an append means.
inline AppendOutcome OutcomeOf(const absl::Status& status) {
  if (status.ok()) return AppendOutcome::kAppended;
  if (absl::IsAborted(status)) return AppendOutcome::kFenced;
  return absl::IsUnknown(status) ? AppendOutcome::kUnknown : AppendOutcome::kRefused;
}

class SharedJournal;  // shared_journal.h
class MeshImport;     // mesh_import.h

class Journal {
 public:
  // Of one mesh; never reused, even for a mesh with the same id.
  using Key = std::int64_t;

  struct Mesh {
    Key key = 0;
    std::string id;  // "@" and the key, if the id is damaged
    std::string description;
    std::uint64_t entries = 0;  // a snapshot counts as one
    absl::Status damage;        // not OK: other fields may be wrong, or there is no data
    absl::Status loss;          // not OK: lacks acknowledged data; it can only be read and deleted
  };
  // Counts since it was opened.
  struct Counts {
    std::uint64_t syncs = 0;     // successful transactions
    std::uint64_t failures = 0;  // failed transactions
    bool failing = false;        // the last transaction failed, or the files are gone
    std::uint64_t fenced = 0;    // appends that were refused, as another object has the mesh
    std::uint64_t unknown = 0;   // appends whose outcome was not found out
    bool gone = false;           // the files at the journal's path are not those that are open
    // How long the oldest writing call under way has not been answered; zero: there is none.
    absl::Duration oldest_write;
  };
  // The changes of a batch.
  struct Entry {
    std::uint64_t revision = 0;  // the revision after it
    std::string data;
  };
  // A request_id and its answer.
  struct Request {
    std::string id;
    std::string answer;
  };
  // Receives the data of a mesh, in this order; revisions have no gap up to the last. An error ends
  // the reading and is returned. While a visitor runs, the files may grow.
  struct Visitor {
    std::function<absl::Status(const Request&)> request;  // the oldest first; null: not read
    std::function<absl::Status(std::uint64_t revision, const std::string& part)> snapshot;
    std::function<absl::Status(const Entry&)> entry;
  };

  virtual ~Journal() = default;

  // Its location, for messages.
  virtual std::string name() const = 0;

  virtual Counts counts() const { return {}; }
  // Refuses all writing calls from now on with `why`, also those that wait for their turn. What was
  // handed to the disk or the database is not waited for here, and ends as before. Does not block.
  virtual void EndWrites(const absl::Status& /*why*/) {}
  // What several servers on one journal need; null: there is one server.
  virtual SharedJournal* shared() { return nullptr; }
  // Takes meshes from other journals; null: it takes none.
  virtual MeshImport* import() { return nullptr; }
  // Its size on the disk.
  virtual std::uint64_t bytes() const { return 0; }

  virtual absl::StatusOr<std::vector<Mesh>> List() = 0;  // by id
  // The new mesh is claimed. ALREADY_EXISTS for an existing id. UNKNOWN: it may be there.
  virtual absl::StatusOr<Key> Create(const std::string& id, const std::string& description) = 0;
  // Makes this object the owner of the mesh, before the mesh is read to be written to. What an
  // earlier owner has in flight is refused from then on. A journal of one process owns all meshes.
  // ABORTED if another object has a lease of the mesh (shared_journal.h).
  virtual absl::Status Claim(Key) { return absl::OkStatus(); }
  // Quick, whatever the size: the mesh becomes invisible, and its rows remain. Needs no claim.
  // UNKNOWN: it may be gone.
  virtual absl::Status Delete(Key mesh) = 0;
  // Removes a part of the invisible rows; other calls run in between. True if there is more. What
  // is left when the journal is closed is removed at the next opening.
  virtual bool Sweep(Key mesh) = 0;

  // Atomic, with one of the three outcomes. The entries follow the last one, and each other. Only
  // the newest requests of a mesh are kept.
  virtual absl::Status Append(Key mesh, const std::vector<Entry>& entries,
                              const std::vector<Request>& requests) = 0;
  // The same for one batch; either part may be missing.
  absl::Status Append(Key mesh, const std::optional<Entry>& entry,
                      const std::optional<Request>& request) {
    return Append(mesh, entry.has_value() ? std::vector{*entry} : std::vector<Entry>(),
                  request.has_value() ? std::vector{*request} : std::vector<Request>());
  }

  // The newest generation. DATA_LOSS if something acknowledged is missing.
  virtual absl::Status Read(Key mesh, const Visitor& visitor) = 0;

  // History: the newest snapshot that is not newer than `from`, and the entries after it up to the
  // revision `to` >= from; no requests. A snapshot of revision 0 has no parts and is not visited.
  virtual absl::Status ReadPast(Key mesh, std::uint64_t from, std::uint64_t to,
                                const Visitor& visitor) = 0;
  // The earliest `from` that ReadPast accepts.
  virtual absl::StatusOr<std::uint64_t> Oldest(Key mesh) = 0;

  // Begins a generation with `parts`, a snapshot at `revision`: later than the newest snapshot, and
  // at most the last revision. The entries after it belong to the new generation. Other calls run
  // in between, also appends to the mesh. At most one call at a time per mesh. Needs the claim,
  // too. After UNAVAILABLE the generation may be there: no reader can tell, and the call can be
  // repeated. CANCELLED soon after `cancelled` turned true, with no effect that a reader sees.
  virtual absl::Status Compact(Key mesh, std::uint64_t revision,
                               const std::vector<std::string>& parts,
                               const std::atomic<bool>& cancelled) = 0;
  // The same to its end.
  absl::Status Compact(Key mesh, std::uint64_t revision, const std::vector<std::string>& parts) {
    const std::atomic<bool> never(false);
    return Compact(mesh, revision, parts, never);
  }
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_JOURNAL_H_
