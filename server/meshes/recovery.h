// A mesh made again from the journal: its snapshot's features as one batch, the batches since one
// by one, so that their diffs are there for watchers. The mesh is a function of its features, so
// revision, hash and ids are those from before; each hash is compared with the one written down.
//
// Hashes of other bits (kMeshBits) cannot be compared. What was written with them is gathered and
// made in one batch. The mesh then is the next revision, with the same features, and the first that
// watchers can resume at; earlier ones can be read as features and reverted to. It is written down
// with a snapshot. (Not so if the mesh cannot be written to: then each start makes it so again.)
//
// Takes as long as making the snapshot's mesh and applying the batches, of which there are no more
// bytes than of the snapshot, or of a least size. Pure but for what it reads; thread-safe.
#ifndef DYNMESH_SERVER_MESHES_RECOVERY_H_
#define DYNMESH_SERVER_MESHES_RECOVERY_H_

#include <cstdint>
#include <functional>
#include <memory>

#include "absl/status/statusor.h"
#include "dynmesh/dynamic_mesh.h"
#include "proto/codec/journal_codec.h"
#include "server/journal/journal.h"
#include "server/meshes/mesh_host.h"

namespace dynmesh::server {

struct RecoveredMesh {
  codec::JournalMesh made;  // options, time, request_id
  std::unique_ptr<DynamicMesh> mesh;
  MeshHost::Past past;
  std::uint64_t entries = 0;  // applied one by one
};

// An error says what does not fit; there is then no mesh to be trusted. `applied` is called after
// each snapshot and each entry.
absl::StatusOr<RecoveredMesh> RecoverMesh(Journal& journal, const Journal::Mesh& found,
                                          const MeshFactory& factory,
                                          const MeshHost::Options& options,
                                          const std::function<void()>& applied);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_RECOVERY_H_
