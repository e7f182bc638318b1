// Single edits of a mesh of points in the unit square or cube, for measurements.
#ifndef DYNMESH_TESTS_E2E_RANDOM_EDITS_H_
#define DYNMESH_TESTS_E2E_RANDOM_EDITS_H_

#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh::test {

class RandomEdits {
 public:
  RandomEdits(std::uint64_t seed, int dimension) : random_(seed), dimension_(dimension) {}

  // Adds the point `id` anywhere.
  Edit Add(FeatureId id) {
    const double x = unit_(random_), y = unit_(random_);
    return Edit::Add(dimension_ == 2 ? Feature::Point(id, x, y)
                                     : Feature::Point(id, x, y, unit_(random_)));
  }
  // Those with ids from 1 to `count`.
  EditBatch Fill(std::size_t count) {
    EditBatch batch;
    for (FeatureId id = 1; id <= count; ++id) batch.push_back(Add(id));
    return batch;
  }
  // Adds a new point, or removes one that Next added.
  Edit Next() {
    if (added_.empty() || random_() % 2 == 0) {
      added_.push_back(next_id_);
      return Add(next_id_++);
    }
    std::swap(added_[random_() % added_.size()], added_.back());
    const FeatureId id = added_.back();
    added_.pop_back();
    return Edit::Remove(id);
  }

 private:
  std::mt19937_64 random_;
  const int dimension_;
  std::uniform_real_distribution<double> unit_{0, 1};
  FeatureId next_id_ = 1'000'000'000;
  std::vector<FeatureId> added_;
};

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_E2E_RANDOM_EDITS_H_
