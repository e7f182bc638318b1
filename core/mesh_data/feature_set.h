// Features by id, with their labels: applies batches to a set, and computes the batch between two
// sets.
//
// Validates only what keeps it a set: for features that a mesh has accepted. Costs: an edit O(1),
// Sorted and Ordered O(n log n), EditsBetween O(n). A value; thread-compatible.
#ifndef DYNMESH_CORE_MESH_DATA_FEATURE_SET_H_
#define DYNMESH_CORE_MESH_DATA_FEATURE_SET_H_

#include <cstddef>
#include <span>
#include <vector>

#include "absl/container/node_hash_map.h"
#include "absl/status/status.h"
#include "dynmesh/feature.h"

namespace dynmesh::mesh_data {

class FeatureSet {
 public:
  // As DynamicMesh::Apply. ALREADY_EXISTS or NOT_FOUND at the first invalid edit; those before it
  // are applied.
  absl::Status Apply(const EditBatch& batch);

  std::size_t size() const { return features_.size(); }
  std::vector<Feature> Sorted() const;  // by id
  // The same without a copy: the features of this set, valid until it changes.
  std::vector<const Feature*> Ordered() const;

 private:
  // A table of the features themselves would be twice as large, and thrice while it grows.
  absl::node_hash_map<FeatureId, Feature> features_;
};

// The batch that turns `from` into `to`, both by ascending id: removes, sets, adds and edits of
// labels by ascending id; one per feature, or a set and then an edit that clears the label. Empty
// if they are equal.
EditBatch EditsBetween(std::span<const Feature> from, std::span<const Feature> to);

}  // namespace dynmesh::mesh_data

#endif  // DYNMESH_CORE_MESH_DATA_FEATURE_SET_H_
