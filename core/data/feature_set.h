// Features by id: what a batch makes of a set, and which batch makes one set of another.
//
// Nothing is validated but what a set needs to stay one: for features that a mesh has accepted.
// Costs: an edit O(1), Sorted O(n log n), EditsBetween O(n). A value; thread-compatible.
#ifndef DYNMESH_CORE_DATA_FEATURE_SET_H_
#define DYNMESH_CORE_DATA_FEATURE_SET_H_

#include <cstddef>
#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"
#include "dynmesh/feature.h"

namespace dynmesh::data {

class FeatureSet {
 public:
  // As DynamicMesh::Apply does. ALREADY_EXISTS or NOT_FOUND at the first edit that cannot act;
  // those before it have.
  absl::Status Apply(const EditBatch& batch);

  std::size_t size() const { return features_.size(); }
  std::vector<Feature> Sorted() const;  // by id

 private:
  absl::flat_hash_map<FeatureId, Feature> features_;
};

// What makes `to` of `from`, both by ascending id: removes, sets and adds, at most one of a
// feature, by ascending id. Empty if they are the same.
EditBatch EditsBetween(std::span<const Feature> from, std::span<const Feature> to);

}  // namespace dynmesh::data

#endif  // DYNMESH_CORE_DATA_FEATURE_SET_H_
