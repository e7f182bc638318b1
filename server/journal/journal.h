// What outlives the process: which meshes there are, and for each a snapshot of its features, the
// batches since, and the last answers to batches with a request_id. An interface; what the bytes
// mean stands in proto/codec/journal_codec.h.
//
// A snapshot and the batches up to the next one are a generation. The newest is what a mesh is made
// again from; the one before is kept, and more if there is room for them, so that older revisions
// can be read: the mesh's history. Its first generation begins at revision 0, with no feature.
//
// Invariants of an implementation:
//   1. a call that returned OK is durable: it survives the process and a loss of power;
//   2. a call that returned an error changed nothing that will be seen while the journal is open.
//      (After a crash a change that failed may turn out to have been made, whole.)
//   3. the entries of a mesh follow its oldest snapshot one by one, without a gap;
//   4. each row has a checksum: one that was damaged is told as DATA_LOSS with mesh and revision;
//   5. a mesh that lacks what was acknowledged, whatever was done to the files, is told so when the
//      journal is opened, and not written to.
// Calls block until the disk is done; calls that wait at the same time may share a sync. After a
// failed write all calls that write fail until one has been tried and done. Thread-safe.
//
// Errors: UNAVAILABLE if it may pass (a full disk), DATA_LOSS if what is stored is no longer sound,
// NOT_FOUND for a mesh that was deleted, FAILED_PRECONDITION for a revision that does not follow,
// OUT_OF_RANGE for one that is not, or no longer, there.
#ifndef DYNMESH_SERVER_JOURNAL_JOURNAL_H_
#define DYNMESH_SERVER_JOURNAL_JOURNAL_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace dynmesh::server {

class Journal {
 public:
  // Of one mesh; never given again, also not to a mesh with the same id.
  using Key = std::int64_t;

  struct Mesh {
    Key key = 0;
    std::string id;  // "@" and the key, if its own is damaged and cannot be said
    std::string description;
    std::uint64_t entries = 0;  // a snapshot counts as one
    absl::Status damage;        // not OK: the rest is not to be trusted, or there is nothing
    absl::Status loss;  // not OK: it lacks what was acknowledged. It can be read and deleted only
  };
  // What it did since it was opened.
  struct Counts {
    std::uint64_t syncs = 0;     // transactions on the disk
    std::uint64_t failures = 0;  // transactions that were not
    bool failing = false;        // the last one was not
  };
  // What a batch did.
  struct Entry {
    std::uint64_t revision = 0;  // that it made
    std::string data;
  };
  // A request_id and its answer.
  struct Request {
    std::string id;
    std::string answer;
  };
  // What is read of a mesh, in this order, revisions without a gap up to the last. An error ends
  // the reading and is returned. Slow visitors make the files grow meanwhile.
  struct Visitor {
    std::function<absl::Status(const Request&)> request;  // the oldest first; null: not read
    std::function<absl::Status(std::uint64_t revision, const std::string& part)> snapshot;
    std::function<absl::Status(const Entry&)> entry;
  };

  virtual ~Journal() = default;

  // Where it is, for people.
  virtual std::string name() const = 0;

  virtual Counts counts() const { return {}; }
  // That it takes where it is.
  virtual std::uint64_t bytes() const { return 0; }

  virtual absl::StatusOr<std::vector<Mesh>> List() = 0;  // by id
  // ALREADY_EXISTS for an id that is there.
  virtual absl::StatusOr<Key> Create(const std::string& id, const std::string& description) = 0;
  // Quick, however much there is of it: nobody finds it any more, and its rows are left.
  virtual absl::Status Delete(Key mesh) = 0;
  // Takes away a piece of what nobody finds any more; others' calls are done in between. True if
  // there is more. What is left when the journal ends is taken away when it is opened.
  virtual bool Sweep(Key mesh) = 0;

  // All of it or nothing. The entries follow the last one, and each other. Of the requests of a
  // mesh only the newest are kept.
  virtual absl::Status Append(Key mesh, const std::vector<Entry>& entries,
                              const std::vector<Request>& requests) = 0;
  // The same of one batch; either may be missing.
  absl::Status Append(Key mesh, const std::optional<Entry>& entry,
                      const std::optional<Request>& request) {
    return Append(mesh, entry.has_value() ? std::vector{*entry} : std::vector<Entry>(),
                  request.has_value() ? std::vector{*request} : std::vector<Request>());
  }

  // The newest generation. DATA_LOSS if something that was told is missing.
  virtual absl::Status Read(Key mesh, const Visitor& visitor) = 0;

  // History: the newest snapshot that is not newer than `from`, and the entries after it up to the
  // revision `to` >= from; no requests. A snapshot of revision 0 has no parts and is not told.
  virtual absl::Status ReadPast(Key mesh, std::uint64_t from, std::uint64_t to,
                                const Visitor& visitor) = 0;
  // The earliest revision that ReadPast may begin at.
  virtual absl::StatusOr<std::uint64_t> Oldest(Key mesh) = 0;

  // Begins a generation with `parts`, a snapshot at `revision`, which is the last one. Others'
  // calls are done in between. One call at a time for a mesh.
  virtual absl::Status Compact(Key mesh, std::uint64_t revision,
                               const std::vector<std::string>& parts) = 0;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_JOURNAL_H_
