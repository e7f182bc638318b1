#include "client/preparation/triangles.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "client/cleaning/surface.h"
#include "client/cleaning/surface_polygons.h"
#include "client/cleaning/tolerance_field.h"
#include "core/base/feature_kinds.h"

namespace dynmesh::preparation {

std::vector<PolygonPart> TrianglesOf(const std::vector<Feature>& features) {
  double size = 0;
  for (const Feature& f : features) {
    if (!IsPoint(f)) continue;
    for (const double x : f.position) size = std::max(size, std::abs(x));
  }
  const cleaning::ToleranceField field(size > 0 ? size : 1);  // not used here
  cleaning::Surface surface(field);
  // Nodes are in the order of coordinates there.
  std::vector<std::pair<cleaning::Point3, FeatureId>> points;
  for (const Feature& f : features) {
    if (IsPoint(f)) points.emplace_back(f.position, f.id);
  }
  std::ranges::sort(points);
  absl::flat_hash_map<FeatureId, cleaning::Node> node_of;
  cleaning::Node last = 0;
  for (const auto& [at, id] : points) {
    if (node_of.empty() || surface.at(last) != at) last = surface.AddNode(at, id);
    node_of[id] = last;
  }
  std::vector<PolygonPart> triangles;
  for (const Feature& f : features) {
    if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
    std::vector<cleaning::NodeRing> rings;
    for (const std::vector<FeatureId>& ring : f.rings) {
      cleaning::NodeRing& nodes = rings.emplace_back();
      for (const FeatureId id : ring) nodes.push_back(node_of.at(id));
    }
    for (const auto& t : cleaning::PiecesOf(surface, rings, 0).triangles) {
      triangles.push_back({{surface.at(t[0]), surface.at(t[1]), surface.at(t[2])}, f.id});
    }
  }
  return triangles;
}

}  // namespace dynmesh::preparation
