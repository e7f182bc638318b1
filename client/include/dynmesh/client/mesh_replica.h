// A copy of a server's mesh that is fed by watch events only and proves itself equal.
//
// Invariants:
//   1. while live, the mesh is the server's at revision(), bit for bit: every diff
//      continued the one before, and the hash came out right after each;
//   2. an event that does not fit makes the replica broken, with the mesh it had, until
//      a snapshot begins: nothing is ever applied on doubt.
//
// Of a watch of some regions it is a copy of the part that is sent: all vertices,
// subsegments and subfacets, the simplices inside, and the hash of these.
//
// A diff takes time proportional to the diff. Thread-compatible.
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
  // Can the replica be relied upon?
  enum class State {
    kEmpty,   // no mesh yet
    kLive,    // the server's mesh at revision()
    kBroken,  // an event was lost or damaged: watch anew, from a snapshot
  };

  struct Nothing {};      // a fragment came that is not the last
  struct NewSnapshot {};  // the mesh was replaced by a whole one
  struct Progress {};     // the server is there, and has nothing new
  // What an event did, once complete.
  using Change = std::variant<Nothing, NewSnapshot, MeshDiff, Progress>;

  // Without a mesh.
  MeshReplica();
  // Takes the mesh of `other`, which may be assigned to and destroyed then.
  MeshReplica(MeshReplica&& other) noexcept;
  // The same.
  MeshReplica& operator=(MeshReplica&& other) noexcept;
  ~MeshReplica();

  // Takes the next `event` of a watch. FAILED_PRECONDITION if it does not continue what the replica
  // has (lost, sent twice, out of order), DATA_LOSS if it is damaged or the hash disagrees: the
  // replica is broken then.
  absl::StatusOr<Change> Take(const v1::WatchEvent& event);

  // The stream ended: fragments without their end are dropped. The mesh stays.
  void EndOfStream();

  State state() const;    // after the last event
  bool has_mesh() const;  // false before the first snapshot is whole

  // These are of the last whole revision, whatever the state; 0 and nothing before the first.

  std::uint64_t revision() const;        // of the mesh
  MeshHash hash() const;                 // of what is held
  int dimension() const;                 // 2 or 3
  std::size_t vertex_count() const;      // those of the domain box included
  std::size_t simplex_count() const;     // triangles, in space tetrahedra
  std::size_t subsegment_count() const;  // those of the domain box included
  std::size_t subfacet_count() const;    // in space
  // With its slots and the patch of the last diff.
  const SlotMesh& mesh() const;
  // The whole mesh, O(size).
  Mesh ToMesh() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_MESH_REPLICA_H_
