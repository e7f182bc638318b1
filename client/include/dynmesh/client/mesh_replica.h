// A copy of a server's mesh that is updated by watch events only and checks its hash.
//
//   dynmesh::client::MeshReplica replica;
//   auto change = replica.Take(event);  // for each event of a Watch stream
//   if (!change.ok()) WatchFromSnapshot();
//
// Invariants:
//   1. while kLive, the mesh is the server's at revision(), bit for bit: every diff continued the
//      one before, and the hash was right after each. Labels of features (SlotMesh::labels) follow
//      the diffs, too; no hash depends on them;
//   2. an event that does not fit makes the replica kBroken, with the mesh that it had, until a
//      snapshot begins. No event is applied in doubt.
//
// Of a watch with regions it is a copy of the part that is sent: all vertices, subsegments and
// subfacets, the simplices inside the regions, and the hash of these.
//
// A diff takes time proportional to its size. Thread-compatible.
#ifndef DYNMESH_CLIENT_MESH_REPLICA_H_
#define DYNMESH_CLIENT_MESH_REPLICA_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <variant>

#include "absl/status/statusor.h"
#include "dynmesh/mesh.h"
#include "dynmesh/slot_mesh.h"

namespace dynmesh::v1 {
class WatchEvent;
}

namespace dynmesh::client {

// The replica; see mesh_replica.h.
class MeshReplica {
 public:
  // The state of the replica.
  enum class State {
    kEmpty,   // no mesh yet
    kLive,    // the server's mesh at revision()
    kBroken,  // an event was lost or damaged: watch again, from a snapshot
  };

  struct Nothing {};      // an incomplete fragment came
  struct NewSnapshot {};  // a snapshot replaced the mesh
  struct Progress {};     // the server is alive and has nothing new
  // The effect of an event.
  using Change = std::variant<Nothing, NewSnapshot, MeshDiff, Progress>;

  // An empty replica.
  MeshReplica();
  // Takes the mesh of `other`, which may then only be assigned to or destroyed.
  MeshReplica(MeshReplica&& other) noexcept;
  // The same.
  MeshReplica& operator=(MeshReplica&& other) noexcept;
  ~MeshReplica();

  // Applies the next `event` of a watch. FAILED_PRECONDITION if it does not continue what the
  // replica has (lost, sent twice, out of order). DATA_LOSS if it is damaged or the hash disagrees.
  // After an error the replica is kBroken.
  absl::StatusOr<Change> Take(const v1::WatchEvent& event);

  // Call it when the stream has ended: drops incomplete fragments. The mesh stays.
  void EndOfStream();

  State state() const;    // after the last event
  bool has_mesh() const;  // false before the first whole snapshot

  // Of the last whole revision, in every state; 0 before the first, which a new mesh has, too: ask
  // has_mesh().

  std::uint64_t revision() const;        // of the mesh
  MeshHash hash() const;                 // of the mesh held
  int dimension() const;                 // 2 or 3
  std::size_t vertex_count() const;      // domain box included
  std::size_t simplex_count() const;     // triangles, in 3D tetrahedra
  std::size_t subsegment_count() const;  // domain box included
  std::size_t subfacet_count() const;    // 3D only
  // The mesh with its slots and the patch of the last diff.
  const SlotMesh& mesh() const;
  // The whole mesh, O(size).
  Mesh ToMesh() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_MESH_REPLICA_H_
