// Recovers a mesh from the journal: claims it, applies its snapshot's features as one batch, and
// the batches since one by one, so that watchers get their diffs. The mesh is a function of its
// features, so revision, hash and ids are the same as before; each hash is compared with the one in
// the journal.
//
// Hashes of other bits (kMeshBits) cannot be compared. The features written with other bits are
// gathered and applied in one batch. The mesh is then the next revision, with the same features,
// and watchers can resume from there on; earlier revisions can be read as features and reverted to.
// The new revision is written with a snapshot. (Not if the mesh is read only: then each start
// repeats this.)
//
// Takes as long as making the snapshot's mesh and applying the batches. These have at most the
// bytes of the snapshot, or of a minimum. Pure except for reading; thread-safe.
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

// Returns an error if the data is inconsistent: DATA_LOSS. `applied` is called after each snapshot
// and each entry.
absl::StatusOr<RecoveredMesh> RecoverMesh(Journal& journal, const Journal::Mesh& found,
                                          const MeshFactory& factory,
                                          const MeshHost::Options& options,
                                          const std::function<void()>& applied);

// The same without a claim, for a server that follows the mesh: nothing is written. UNIMPLEMENTED
// if the journal has other bits: what its owner makes differs from what this program makes.
absl::StatusOr<RecoveredMesh> ReadMesh(Journal& journal, const Journal::Mesh& found,
                                       const MeshFactory& factory,
                                       const MeshHost::Options& options);

// The past of a mesh with those options, made again from the journal: its revisions from `from` on,
// or from an earlier one, up to `to`. As long as `interrupted` returns false, which is asked every
// few microseconds; then CANCELLED. OUT_OF_RANGE if the journal does not go back as far;
// UNIMPLEMENTED for other bits. What a store's limits drop is missing. Time and memory as of
// RecoverMesh.
absl::StatusOr<std::shared_ptr<RevisionStore>> ReadPast(Journal& journal, Journal::Key mesh,
                                                        const MeshOptions& made_with,
                                                        const MeshFactory& factory,
                                                        const MeshHost::Options& options,
                                                        std::uint64_t from, std::uint64_t to,
                                                        const std::function<bool()>& interrupted);

// An answer as a mesh remembers it. DATA_LOSS.
absl::StatusOr<RequestMemory::Entry> DecodeAnswer(const Journal::Request& request);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_RECOVERY_H_
