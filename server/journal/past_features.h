// Collects the features of a mesh at a revision from its journal: those of a snapshot, changed by
// the batches after it. Its two calls are a journal's visitor. O(features) in memory, O(1) for each
// feature and edit. Thread-compatible.
#ifndef DYNMESH_SERVER_JOURNAL_PAST_FEATURES_H_
#define DYNMESH_SERVER_JOURNAL_PAST_FEATURES_H_

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/mesh_data/feature_set.h"
#include "dynmesh/codec/features_at.h"
#include "dynmesh/mesh.h"
#include "proto/codec/journal_codec.h"
#include "server/journal/journal.h"

namespace dynmesh::server {

class PastFeatures {
 public:
  // `empty`: the hash of the mesh without features. Once `cancelled`, which may be null, is true,
  // the calls return CANCELLED.
  PastFeatures(int dimension, const MeshHash& empty, const std::atomic<bool>* cancelled)
      : dimension_(dimension), cancelled_(cancelled), hash_(empty) {}

  // The next part of a snapshot, the next batch. DATA_LOSS if it does not fit what was before.
  absl::Status AddPart(std::uint64_t revision, const std::string& part);
  absl::Status Apply(const Journal::Entry& entry);

  // Of the last one that was taken.
  std::uint64_t revision() const { return revision_; }
  const MeshHash& hash() const { return hash_; }
  std::uint32_t bits() const { return bits_; }  // to which the hash belongs
  const mesh_data::FeatureSet& features() const { return features_; }
  codec::FeaturesAt Copy() const { return {revision_, hash_, features_.Sorted()}; }

 private:
  absl::Status Take(std::uint64_t revision, const codec::JournalEntry& entry);

  const int dimension_;
  const std::atomic<bool>* const cancelled_;
  mesh_data::FeatureSet features_;
  std::uint64_t revision_ = 0;
  MeshHash hash_;
  std::uint32_t bits_ = kMeshBits;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_PAST_FEATURES_H_
