#include "client/preparation/thinning.h"

#include <map>
#include <string>
#include <utility>

#include "client/cleaning/feature_edges.h"
#include "core/base/feature_kinds.h"

namespace dynmesh::preparation {

absl::flat_hash_map<FeatureId, std::uint32_t> GroupsOf(const std::vector<Feature>& features,
                                                       const io::FeatureLabels& labels) {
  absl::flat_hash_map<FeatureId, std::uint32_t> groups;
  std::map<std::pair<std::int64_t, std::string>, std::uint32_t> numbers;
  numbers[{0, ""}] = 0;
  for (const Feature& f : features) {
    if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
    const auto next = static_cast<std::uint32_t>(numbers.size());
    groups[f.id] =
        numbers.try_emplace({labels.MarkerOf(f.id), labels.NameOf(f.id)}, next).first->second;
  }
  return groups;
}

ThinningCounts Thin(double within, double tolerance, io::Geometry& geometry) {
  cleaning::FeatureEdgeOptions options;
  options.angle = kThinningAngle;
  options.within = within;
  options.tolerance = tolerance;
  options.groups = GroupsOf(geometry.features, *geometry.labels);
  options.holes = false;
  auto kept = cleaning::KeepFeatureEdges(geometry.features, options);
  if (!kept.ok() || kept->changes.empty()) return {};
  geometry.features = std::move(kept->features);
  io::KeepPlacesOfParts(kept->parts, geometry);
  return {kept->changes.size(), kept->triangles_before, kept->triangles};
}

}  // namespace dynmesh::preparation
