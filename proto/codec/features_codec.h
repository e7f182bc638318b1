// Features: messages <-> library types, in chunks below 1 MB, like mesh_codec.h for meshes. A
// feature that is larger has a chunk of its own. Thread-compatible.
#ifndef DYNMESH_PROTO_CODEC_FEATURES_CODEC_H_
#define DYNMESH_PROTO_CODEC_FEATURES_CODEC_H_

#include <cstddef>
#include <optional>
#include <utility>

#include "absl/status/statusor.h"
#include "dynmesh/codec/features_at.h"
#include "dynmesh/v1/mesh_service.pb.h"
#include "proto/codec/mesh_codec.h"

namespace dynmesh::codec {

class FeaturesFragmenter {
 public:
  FeaturesFragmenter(FeaturesAt features, int dimension, std::size_t chunk_bytes = kFragmentBytes)
      : features_(std::move(features)), dimension_(dimension), chunk_bytes_(chunk_bytes) {}

  // Fills `out` (cleared first) with the next chunk. False if none is left.
  bool Next(v1::FeaturesChunk* out);
  bool done() const { return done_; }

 private:
  const FeaturesAt features_;
  const int dimension_;
  const std::size_t chunk_bytes_;
  std::size_t next_ = 0;
  bool done_ = false;
};

class FeaturesAssembler {
 public:
  explicit FeaturesAssembler(int dimension) : dimension_(dimension) {}

  // All features after the last chunk, nullopt before. DATA_LOSS for chunks that do not fit
  // together.
  absl::StatusOr<std::optional<FeaturesAt>> Add(const v1::FeaturesChunk& chunk);

 private:
  const int dimension_;
  std::optional<FeaturesAt> features_;
};

}  // namespace dynmesh::codec

#endif  // DYNMESH_PROTO_CODEC_FEATURES_CODEC_H_
