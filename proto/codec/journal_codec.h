// A journal's records of a mesh: encoding and decoding. Pure, thread-safe. Decoding validates
// everything: DATA_LOSS for malformed bytes.
#ifndef DYNMESH_PROTO_CODEC_JOURNAL_CODEC_H_
#define DYNMESH_PROTO_CODEC_JOURNAL_CODEC_H_

#include <atomic>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"

namespace dynmesh::codec {

struct JournalMesh {
  MeshOptions options;
  absl::Time create_time;
  std::string request_id;
};
std::string EncodeJournalMesh(const JournalMesh& mesh);
absl::StatusOr<JournalMesh> DecodeJournalMesh(const std::string& bytes);

struct JournalEntry {
  EditBatch edits;
  MeshHash hash;                   // of the mesh after them
  std::uint32_t bits = kMeshBits;  // to which the hash belongs
};
std::string EncodeJournalEntry(const EditBatch& edits, const MeshHash& hash, int dimension,
                               std::uint32_t bits = kMeshBits);
absl::StatusOr<JournalEntry> DecodeJournalEntry(const std::string& bytes, int dimension);

// Features in parts of about a megabyte, at least one part; each part has the hash.
std::vector<std::string> EncodeJournalSnapshot(std::span<const Feature> features,
                                               const MeshHash& hash, int dimension,
                                               std::uint32_t bits = kMeshBits);
// The same of features that lie elsewhere. Stops soon after `cancelled` turned true; then what it
// returns is of no use.
std::vector<std::string> EncodeJournalSnapshot(std::span<const Feature* const> features,
                                               const MeshHash& hash, int dimension,
                                               const std::atomic<bool>& cancelled);
// Appends a part's features to `out` as edits that add them.
absl::Status DecodeJournalSnapshot(const std::string& bytes, int dimension, JournalEntry* out);

// The hash in an entry or in a part of a snapshot, without decoding the rest. O(bytes) in time,
// O(1) in memory.
absl::StatusOr<MeshHash> DecodeJournalHash(const std::string& bytes);

struct JournalAnswer {
  std::uint64_t content_a = 0, content_b = 0;
  std::uint64_t from_revision = 0, to_revision = 0;
  MeshHash hash;
  WorkCounters work;
};
std::string EncodeJournalAnswer(const JournalAnswer& answer);
absl::StatusOr<JournalAnswer> DecodeJournalAnswer(const std::string& bytes);

}  // namespace dynmesh::codec

#endif  // DYNMESH_PROTO_CODEC_JOURNAL_CODEC_H_
