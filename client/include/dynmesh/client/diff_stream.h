// The revisions of one mesh since a given one, to be taken one after the other: a Watch stream that
// reconnects where it was when the connection breaks. For a caller that keeps the mesh itself.
//
// A thread of its own reads ahead, a few revisions far. Thread-safe.
#ifndef DYNMESH_CLIENT_DIFF_STREAM_H_
#define DYNMESH_CLIENT_DIFF_STREAM_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "dynmesh/mesh.h"

namespace dynmesh::client {

// Where a stream begins, and what it does when the server is away.
struct DiffStreamOptions {
  // Where the caller's mesh is.
  std::uint64_t start_revision = 0;
  // Of the caller's mesh. The server refuses with FAILED_PRECONDITION (DIVERGED) if its own had
  // another hash at that revision.
  MeshHash start_hash;
  // If the server has not kept the revisions since: true: a whole mesh comes in their place,
  // false: OUT_OF_RANGE (COMPACTED).
  bool takes_snapshots = false;
  // For how long in a row the server may not be reached.
  absl::Duration patience = absl::Minutes(15);
};

// A stream of revisions; see diff_stream.h.
class DiffStream {
 public:
  virtual ~DiffStream() = default;  // as Cancel

  // The way to the next revision, or a whole mesh (DiffStreamOptions::takes_snapshots).
  using Event = std::variant<MeshDiff, Mesh>;
  // The next revision; nothing if none came within `limit`. An error ends the stream.
  virtual absl::StatusOr<std::optional<Event>> Next(absl::Duration limit) = 0;
  // Ends the stream, from any thread: Next returns CANCELLED.
  virtual void Cancel() = 0;
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_DIFF_STREAM_H_
