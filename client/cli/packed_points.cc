#include "client/cli/packed_points.h"

#include <algorithm>

#include "core/base/feature_kinds.h"

namespace dynmesh::cli {

void PackedPoints::Pack(std::vector<Feature>& features) {
  constexpr std::size_t kMany = 1000;
  const auto is_plain = [](const Feature& f) { return IsPoint(f) && !f.label && !f.unsplit; };
  if (features.size() < kMany || !std::ranges::all_of(features, is_plain)) return;
  points_.reserve(features.size());
  for (const Feature& f : features) points_.emplace_back(f.id, f.position);
  std::vector<Feature>().swap(features);
}

void PackedPoints::Unpack(std::vector<Feature>& features) {
  if (points_.empty()) return;
  features.reserve(points_.size());
  for (const auto& [id, at] : points_) {
    features.push_back(Feature::Point(id, at[0], at[1], at[2]));
  }
  points_.clear();
  points_.shrink_to_fit();
}

}  // namespace dynmesh::cli
