// A copy of a server's mesh that is fed by watch events only and proves itself equal.
//
// Invariants:
//   1. while live, the mesh is the server's at revision(), bit for bit: every diff
//      continued the one before, and the hash came out right after each;
//   2. an event that does not fit makes the replica broken, with the mesh it had, until
//      a snapshot begins: nothing is ever applied on doubt.
// Of a watch of some regions it is a copy of the part that is sent: all vertices,
// subsegments and subfacets, the simplices inside, and the hash of these.
//
// A diff takes time proportional to the diff. Thread-compatible.
#ifndef DYNMESH_CLIENT_MESH_REPLICA_H_
#define DYNMESH_CLIENT_MESH_REPLICA_H_

#include <cstdint>
#include <optional>
#include <variant>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/data/mesh_store.h"
#include "dynmesh/mesh.h"
#include "proto/codec/mesh_codec.h"

namespace dynmesh::v1 {
class WatchEvent;
}

namespace dynmesh::client {

class MeshReplica {
 public:
  enum class State {
    kEmpty,   // no mesh yet
    kLive,    // the server's mesh at revision()
    kBroken,  // an event was lost or damaged: watch anew, from a snapshot
  };

  // What an event did, once complete; kNothing for a fragment that is not the last.
  struct Nothing {};
  struct NewSnapshot {};
  struct Progress {};
  using Change = std::variant<Nothing, NewSnapshot, MeshDiff, Progress>;

  // FAILED_PRECONDITION if the event does not continue what the replica has (lost, sent
  // twice, out of order), DATA_LOSS if it is damaged or the hash disagrees: the replica
  // is broken then.
  absl::StatusOr<Change> Take(const v1::WatchEvent& event);

  // The stream ended: fragments without their end are dropped. The mesh stays.
  void EndOfStream();

  State state() const { return state_; }
  bool has_mesh() const { return has_mesh_; }
  // Of the last whole revision, whatever the state; 0 and nothing before the first.
  std::uint64_t revision() const { return store_.revision(); }
  MeshHash hash() const { return store_.hash(); }
  const data::MeshStore& store() const { return store_; }
  Mesh ToMesh() const { return store_.ToMesh(); }

 private:
  absl::StatusOr<Change> TakeSnapshot(const v1::SnapshotChunk& chunk);
  absl::StatusOr<Change> TakeDiff(const v1::MeshDiff& fragment);
  absl::StatusOr<Change> TakeProgress(std::uint64_t revision, const std::string& hash) const;

  State state_ = State::kEmpty;
  bool has_mesh_ = false;
  data::MeshStore store_;
  codec::SnapshotAssembler snapshot_;
  codec::DiffAssembler diff_;
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_MESH_REPLICA_H_
