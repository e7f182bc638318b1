// Follows one mesh: a Watch stream that feeds a replica, begins again from a snapshot
// when an event does not fit, and reconnects when the connection breaks.
//
// No thread belongs to a session: gRPC's own threads run it. Thread-safe.
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

// What is watched, and what happens when the connection breaks.
struct WatchOptions {
  // Polygons: of the simplices, only those inside at least one of them. Empty: all. The
  // replica's vertices, subsegments, subfacets and hash: see MeshReplica.
  std::vector<FeatureId> regions = {};
  // Longest silence of the server; zero: its default.
  absl::Duration progress_interval = absl::ZeroDuration();
  // Before the first reconnection; doubled before each further one.
  absl::Duration first_pause = absl::Milliseconds(50);
  // Before any reconnection.
  absl::Duration longest_pause = absl::Seconds(5);
  // Reconnections in a row without an event before the session gives up. A server that starts
  // answers UNAVAILABLE until it has all its meshes: by default it has a quarter of an hour for
  // that.
  int max_attempts = 200;
};

// Told of what happens, one call at a time, by gRPC's threads: be quick. The replica
// is the session's, to be read during the call only. Do not call the session here.
class WatchListener {
 public:
  virtual ~WatchListener() = default;
  // The mesh was replaced by a whole one.
  virtual void OnSnapshot(const MeshReplica&) {}
  // The mesh is at the next revision, by that diff.
  virtual void OnDiff(const MeshReplica&, const MeshDiff&) {}
  // The server is there, and has nothing new.
  virtual void OnProgress(const MeshReplica&) {}
  // The replica was broken or the connection lost; the session goes on.
  virtual void OnTrouble(const absl::Status&) {}
  // Nothing will follow.
  virtual void OnEnd(const absl::Status&) {}
};

// A mesh that is followed; see watch_session.h.
class WatchSession {
 public:
  virtual ~WatchSession() = default;  // as Stop

  // Ends the session and returns when no listener call is under way. Not from a
  // listener.
  virtual void Stop() = 0;

  // Waits until `condition` holds of the replica, looked at after every event; false
  // if it takes longer than `limit` or the session ends before.
  virtual bool WaitFor(const std::function<bool(const MeshReplica&)>& condition,
                       absl::Duration limit) = 0;
  // The same for the replica to be at `revision` or a later one, within `limit`.
  bool WaitForRevision(std::uint64_t revision, absl::Duration limit) {
    return WaitFor([revision](const MeshReplica& r) { return r.revision() >= revision; }, limit);
  }

  // Runs `reader` on the replica while no event comes in between.
  virtual void Read(const std::function<void(const MeshReplica&)>& reader) const = 0;

  // The status with which the session ended, if it has.
  virtual std::optional<absl::Status> ended() const = 0;
  // Snapshots taken after the first.
  virtual int resyncs() const = 0;
  // Streams opened after the first.
  virtual int reconnects() const = 0;
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_WATCH_SESSION_H_
