// Changes of the input's features between two propagations.
#ifndef DYNMESH_CORE_MESHING_FEATURE_CHANGES_H_
#define DYNMESH_CORE_MESHING_FEATURE_CHANGES_H_

#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

#include "core/meshing/input_features.h"

namespace dynmesh::meshing {

// A feature and whether it came.
template <int D>
using FeatureChanges = std::vector<std::pair<InputFeature<D>, bool>>;

template <int D>
Extent<D> BoxOf(const InputFeature<D>& feature) {
  Extent<D> box = Extent<D>::Nothing();
  box.AddBall(feature.p, 0);
  box.AddBall(feature.q, 0);
  return box;
}

// Keeps what changed in the end. A segment of which only the shape or the owner changed was removed
// and added: no change.
template <int D>
void KeepNetChanges(FeatureChanges<D>& changes) {
  std::sort(changes.begin(), changes.end(), [](const auto& x, const auto& y) {
    return std::tuple(x.first.a, x.first.b, x.first.unsplit) <
           std::tuple(y.first.a, y.first.b, y.first.unsplit);
  });
  std::size_t kept = 0;
  for (std::size_t i = 0, next = 0; i < changes.size(); i = next) {
    const InputFeature<D> f = changes[i].first;
    int net = 0;
    for (; next < changes.size() && changes[next].first == f; ++next) {
      net += changes[next].second ? 1 : -1;
    }
    if (net != 0) changes[kept++] = {f, net > 0};
  }
  changes.resize(kept);
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_FEATURE_CHANGES_H_
