#include "client/preparation/thinning.h"

#include <utility>

#include "client/cleaning/feature_edges.h"
#include "core/io/common/feature_labels.h"

namespace dynmesh::preparation {

ThinningCounts DropCorners(double within, double tolerance, io::Geometry& geometry) {
  cleaning::FeatureEdgeOptions options;
  options.angle = kThinningAngle;
  options.within = within;
  options.tolerance = tolerance;
  io::LabelNumbers numbers(*geometry.labels);
  options.group = [&](FeatureId id) { return numbers.Of(id); };
  options.holes = false;
  auto kept = cleaning::KeepFeatureEdges(geometry.features, options);
  if (!kept.ok() || kept->changes.empty()) return {};
  geometry.features = std::move(kept->features);
  io::KeepPlacesOfParts(kept->parts, geometry);
  return {kept->changes.size(), kept->triangles_before, kept->triangles};
}

}  // namespace dynmesh::preparation
