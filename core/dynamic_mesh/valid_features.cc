#include "dynmesh/valid_features.h"

#include <algorithm>

#include "core/plc/messages.h"
#include "core/plc/plc.h"

namespace dynmesh {
namespace {

template <int D>
absl::Status Validate(std::span<const Feature> features, const MeshOptions& options) {
  return plc::Plc<D>(options).Check(plc::Edits::Adding(features)).status();
}

}  // namespace

ValidFeatures::ValidFeatures(std::span<const Feature> features, const MeshOptions& options)
    : features_(features.begin(), features.end()), options_(options) {}

absl::StatusOr<std::shared_ptr<const ValidFeatures>> ValidFeatures::Of(
    std::span<const Feature> features, const MeshOptions& options) {
  if (absl::Status status = ValidateOptions(options); !status.ok()) return status;
  if (options.kind != MeshKind::kQuadtree) {
    if (absl::Status status = plc::CheckMaxEdge(options); !status.ok()) return status;
  }
  if (absl::Status status =
          options.dimension == 2 ? Validate<2>(features, options) : Validate<3>(features, options);
      !status.ok()) {
    return status;
  }
  return std::shared_ptr<const ValidFeatures>(new ValidFeatures(features, options));
}

bool ValidFeatures::Proves(std::span<const Feature> features, const MeshOptions& options) const {
  MeshOptions validated = options_;
  validated.min_dihedral = options.min_dihedral;
  return validated == options && std::ranges::equal(features_, features);
}

}  // namespace dynmesh
