// The revisions of one mesh since a given one, in order: a Watch stream that reconnects and resumes
// where it was. For a caller that keeps the mesh itself.
//
//   auto stream = client->StreamDiffs("plate", {.start_revision = mesh.revision,
//                                               .start_hash = mesh.hash});
//   while (true) {
//     auto event = stream->Next(absl::Seconds(1));
//     if (!event.ok()) break;               // the stream has ended
//     if (!event->has_value()) continue;    // no revision came in a second
//     absl::Status status = dynmesh::ApplyDiff(mesh, std::get<dynmesh::MeshDiff>(**event));
//   }
//
// Its own thread reads ahead, up to 16 revisions. Thread-safe.
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

// Where a stream begins, and how long it retries.
struct DiffStreamOptions {
  // The revision of the caller's mesh.
  std::uint64_t start_revision = 0;
  // The hash of the caller's mesh. OUT_OF_RANGE (DIVERGED) if the server's mesh had another hash at
  // that revision.
  MeshHash start_hash;
  // What to do if the server does not hold the revisions since, or the meshes diverged. true: send
  // the whole mesh instead. false: OUT_OF_RANGE (COMPACTED, FUTURE_REVISION, DIVERGED).
  bool takes_snapshots = false;
  // The longest time without a message from the server. On UNAVAILABLE, CANCELLED, UNKNOWN,
  // INTERNAL, RESOURCE_EXHAUSTED and DEADLINE_EXCEEDED the stream reconnects: after pauses of about
  // a third of the time since the last message, 50 ms to 2 s, and at once when a server that could
  // not be reached can be. After this time, or on another status, it ends with that status.
  absl::Duration patience = absl::Minutes(15);
};

// A stream of revisions; see diff_stream.h.
class DiffStream {
 public:
  virtual ~DiffStream() = default;  // as Cancel

  // The next diff, or a whole mesh (DiffStreamOptions::takes_snapshots).
  using Event = std::variant<MeshDiff, Mesh>;
  // Waits for the next revision; nothing if none came within `limit`. An error is the stream's end:
  // CANCELLED after Cancel, else the status of DiffStreamOptions::patience. Revisions that were
  // read before the end come first.
  virtual absl::StatusOr<std::optional<Event>> Next(absl::Duration limit) = 0;
  // Ends the stream from any thread: Next returns CANCELLED.
  virtual void Cancel() = 0;
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_DIFF_STREAM_H_
