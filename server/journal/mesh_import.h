// How a mesh comes into a journal together with its past: keys, rows that no reader sees, and the
// transaction that makes them a mesh. What an end in the middle leaves behind belongs to no mesh
// and is swept at the next opening. Implemented by journals; journal_copy.h calls it. No server may
// use the journal meanwhile.
//
// Calls block until the disk is done. Errors: UNAVAILABLE as Journal's, and those named here.
// Thread-safe.
#ifndef DYNMESH_SERVER_JOURNAL_MESH_IMPORT_H_
#define DYNMESH_SERVER_JOURNAL_MESH_IMPORT_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/journal/journal.h"

namespace dynmesh::server {

class MeshImport {
 public:
  // A part of the snapshot of that revision; numbers count from 0.
  struct Part {
    std::uint64_t revision = 0;
    std::int64_t number = 0;
    std::string data;
  };
  struct Generation {
    std::uint64_t revision = 0;  // of its snapshot
    std::uint64_t parts = 0;     // 0 at revision 0
    std::uint64_t snapshot_bytes = 0, entry_bytes = 0;
  };
  struct Whole {
    std::string id, description;
    std::uint64_t head = 0;               // last revision
    std::vector<Generation> generations;  // the oldest first, at least one
    std::vector<Journal::Request> requests;

    std::uint64_t entries() const { return head - generations.front().revision; }
    std::uint64_t parts() const {
      std::uint64_t sum = 0;
      for (const Generation& generation : generations) sum += generation.parts;
      return sum;
    }
  };

  virtual ~MeshImport() = default;

  // A key that no mesh has or ever had.
  virtual absl::StatusOr<Journal::Key> NewKey() = 0;
  // One transaction, after which no reader sees anything. The entries follow each other. If no
  // Publish is to come, Journal::Sweep removes what was written.
  virtual absl::Status WriteUnseen(Journal::Key mesh, const std::vector<Part>& parts,
                                   const std::vector<Journal::Entry>& entries) = 0;
  // Atomic: from now on the journal has the mesh, with all that was written for it and the
  // requests. It belongs to no server. ALREADY_EXISTS for an existing id; FAILED_PRECONDITION if
  // not all rows are there.
  virtual absl::Status Publish(Journal::Key mesh, const Whole& whole) = 0;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_MESH_IMPORT_H_
