// Copies meshes from one journal to another, whatever keeps them, with all that the source has of
// them: generations, revisions, hashes, answers to requests. Bytes are copied as they are, so the
// mesh, its past and its ids are the same in the target.
//
// Each mesh comes whole or not at all: it is visible in the target only when everything is written,
// and it is then read back and compared with what was read from the source. A mesh that the target
// has already is compared in the same way. If it is the same, it counts as copied: so a copy that
// was interrupted is repeated, and goes on. If it is another, nothing is copied.
//
// The meshes are claimed in the source before they are read. A server that the caller has
// overlooked is fenced from then on.
#ifndef DYNMESH_SERVER_JOURNAL_JOURNAL_COPY_H_
#define DYNMESH_SERVER_JOURNAL_JOURNAL_COPY_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/journal/journal.h"

namespace dynmesh::server {

struct CopyOptions {
  std::vector<std::string> meshes;  // ids; empty: all
  std::uint64_t transaction_bytes = 4 << 20;
  absl::Duration report_interval = absl::Seconds(5);  // between log lines of one mesh
};

struct CopyCounts {
  std::uint64_t copied = 0;     // meshes
  std::uint64_t there = 0;      // meshes that the target had already
  std::uint64_t revisions = 0;  // entries of both
  std::uint64_t bytes = 0;      // of parts, entries and answers of both
};

// Blocks for as long as reading the source once and the target once takes, and writing. O(one
// transaction + the largest batch + the answers of a mesh) in memory. Progress is logged.
//
// Before anything is written: NOT_FOUND if the source lacks a named mesh, DATA_LOSS if one of the
// meshes is damaged or lacks acknowledged data, ALREADY_EXISTS if the target has another mesh of
// that name. Later: DATA_LOSS if rows of a mesh are damaged, or if it was read back differently (it
// is then deleted from the target); UNAVAILABLE. Meshes copied before the error stay.
absl::StatusOr<CopyCounts> CopyMeshes(Journal& from, Journal& to, const CopyOptions& options);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_JOURNAL_COPY_H_
