// Follows one mesh: a Watch stream updates a replica. It starts again from a snapshot if an event
// does not fit, and reconnects if the connection breaks.
//
//   auto session = client->Watch("plate", {}, nullptr);
//   if (session->WaitForRevision(result->diff.to_revision, absl::Seconds(5))) {
//     session->Read([](const dynmesh::client::MeshReplica& replica) { Use(replica.mesh()); });
//   }
//
// A session has no thread of its own: gRPC's threads run it. Thread-safe.
#ifndef DYNMESH_CLIENT_WATCH_SESSION_H_
#define DYNMESH_CLIENT_WATCH_SESSION_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "dynmesh/client/mesh_replica.h"
#include "dynmesh/mesh.h"

namespace dynmesh::client {

// What is watched, and how the session reconnects.
struct WatchOptions {
  // Ids of polygons: only the simplices inside at least one of them. Empty: all. For vertices,
  // subsegments, subfacets and hash see MeshReplica.
  std::vector<FeatureId> regions = {};
  // The longest interval between messages of the server; zero: its default.
  absl::Duration progress_interval = absl::ZeroDuration();
  // The pause before the first reconnection. Later pauses are about a third of the time since the
  // last event. A server that could not be reached is asked as soon as it can be.
  absl::Duration first_pause = absl::Milliseconds(50);
  // The longest pause before a reconnection; each is a fifth longer or shorter by chance.
  absl::Duration longest_pause = absl::Seconds(5);
  // The most reconnections in a row without an event; then the session ends. A starting server
  // answers UNAVAILABLE until it has recovered its meshes: the default allows a quarter of an hour.
  int max_attempts = 200;
};

// Receives the events of a session, one call at a time, on gRPC's threads: return quickly. The
// replica is the session's; read it during the call only. Do not call the session here.
class WatchListener {
 public:
  virtual ~WatchListener() = default;
  // A snapshot replaced the mesh.
  virtual void OnSnapshot(const MeshReplica&) {}
  // That diff was applied: the mesh is at the next revision.
  virtual void OnDiff(const MeshReplica&, const MeshDiff&) {}
  // The server is alive and has nothing new.
  virtual void OnProgress(const MeshReplica&) {}
  // The replica is broken or the connection lost; the session continues.
  virtual void OnTrouble(const absl::Status&) {}
  // The last call.
  virtual void OnEnd(const absl::Status&) {}
};

// A followed mesh; see watch_session.h.
class WatchSession {
 public:
  virtual ~WatchSession() = default;  // as Stop

  // Ends the session; returns when no listener call is running. Do not call it from a listener.
  virtual void Stop() = 0;

  // Waits until `condition` holds for the replica; evaluates it after every event. False if `limit`
  // is exceeded or the session ends first. The replica is empty before the first snapshot: see
  // MeshReplica::has_mesh.
  virtual bool WaitFor(const std::function<bool(const MeshReplica&)>& condition,
                       absl::Duration limit) = 0;
  // Waits until the replica has a mesh, at `revision` or a later one, at most `limit`. With
  // revision 0 that is the first snapshot.
  bool WaitForRevision(std::uint64_t revision, absl::Duration limit) {
    return WaitFor(
        [revision](const MeshReplica& r) { return r.has_mesh() && r.revision() >= revision; },
        limit);
  }

  // Runs `reader` on the replica; no event is applied meanwhile.
  virtual void Read(const std::function<void(const MeshReplica&)>& reader) const = 0;

  // The status with which the session ended; nothing while it runs. CANCELLED after Stop. The
  // session reconnects on UNAVAILABLE, CANCELLED, UNKNOWN, INTERNAL, RESOURCE_EXHAUSTED,
  // DEADLINE_EXCEEDED and the stream's end, and starts from a snapshot on OUT_OF_RANGE or an event
  // that does not fit. It ends after WatchOptions::max_attempts, or with any other status, such as
  // NOT_FOUND (MESH_NOT_FOUND, MESH_DELETED).
  virtual std::optional<absl::Status> ended() const = 0;
  // Snapshots after the first.
  virtual int resyncs() const = 0;
  // Streams after the first.
  virtual int reconnects() const = 0;
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_WATCH_SESSION_H_
