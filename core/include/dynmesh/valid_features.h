// Features that a mesh accepts, with the proof of it. A build that has it does not validate them
// again; of other features or options the proof says nothing, and they are validated as always.
//
//   const auto valid = dynmesh::ValidFeatures::Of(features, options);  // check valid.ok()
//   dynmesh::BuildOptions build;
//   build.valid = *valid;
//   const auto mesh = dynmesh::BuildMesh(features, options, build);
//
// Immutable; thread-safe.
#ifndef DYNMESH_VALID_FEATURES_H_
#define DYNMESH_VALID_FEATURES_H_

#include <memory>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh {

// Only validation makes one. It holds the features and the options that were validated, by value.
class ValidFeatures {
 public:
  // Validates `features` as those of a mesh of `options` that has no others. Errors: those of
  // Create and of DynamicMesh::Validate. Never null. Copies the features.
  static absl::StatusOr<std::shared_ptr<const ValidFeatures>> Of(std::span<const Feature> features,
                                                                 const MeshOptions& options);

  // Is it the proof for `features`, in this order and with these labels, in a mesh of `options`? A
  // min_dihedral of any value: no rule depends on it. O(n).
  bool Proves(std::span<const Feature> features, const MeshOptions& options) const;

 private:
  ValidFeatures(std::span<const Feature> features, const MeshOptions& options);

  const std::vector<Feature> features_;
  const MeshOptions options_;
};

}  // namespace dynmesh

#endif  // DYNMESH_VALID_FEATURES_H_
